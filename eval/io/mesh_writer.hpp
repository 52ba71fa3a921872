#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../refine/rules/polygon_mesh.hpp"
#include "../surface/triangle_mesh.hpp"

#include <filesystem>

namespace tetrakis {

class AtomicFile;  // hier/base/files.hpp

enum class MeshFormat {
    obj,  ///< text; doubles as their shortest round-trip form, g and usemtl lines where group or material changes
    ply,  ///< binary little-endian; doubles; UVs per face corner (texcoord), material_index and group_index per face
    glb,  ///< glTF 2.0 binary; floats about a local origin, split at UV seams, one node per group
};

/// The format that a file name's extension stands for, in either case.
/// @throws Error unsupported: another extension or none
MeshFormat mesh_format(const std::filesystem::path& path);

/// Writes a mesh in the format that the extension says. The file appears whole or not at all (see AtomicFile), with the
/// same bytes for any number of threads. Vertices keep their order and are never merged. PLY and GLB, which have one
/// normal per vertex, get the copies that creases need after the others, GLB also those that UV seams need; the
/// polygons of GLB are cut into triangles by the rule of triangulate().
/// @throws Error  unsupported (extension; more than 4 GiB of GLB), invalid_input (the mesh contradicts itself or has a
///                number that is not finite), io (with the reason), cancelled
void write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh, const RunContext& context = {});
void write_mesh(const std::filesystem::path& path, const PolygonMesh& mesh, const RunContext& context = {});
/// The same into a file that the caller commits, alone or together with others (FileSet).
void write_mesh(AtomicFile& file, const TriangleMesh& mesh, const RunContext& context = {});
void write_mesh(AtomicFile& file, const PolygonMesh& mesh, const RunContext& context = {});
/// The same for a part of a model: its GLB has the local origin of the whole, so that vertices which parts share are
/// the same floats in all of them.
/// @param whole  the model's box
void write_mesh_part(AtomicFile& file, const TriangleMesh& mesh, const Box3d& whole, const RunContext& context = {});

/// The local origin of a GLB: its node's translation, exact in float. Zero where the model lies about the origin.
Vec3d glb_origin(const Box3d& box);

/// Bound on how far the vertices of a model within `box` move when a GLB is written: each coordinate is rounded to
/// float relative to glb_origin.
double glb_rounding_bound(const Box3d& box);

/// The same for every model whose own box lies somewhere inside `box`.
double glb_rounding_bound_within(const Box3d& box);

}  // namespace tetrakis
