#pragma once

#include "../../hier/base/run_context.hpp"
#include "mesh_view.hpp"

#include <filesystem>

namespace tetrakis {

class AtomicFile;  // hier/base/files.hpp

enum class MeshFormat {
    obj,  ///< text; doubles in their shortest exact form, g and usemtl lines where group or material changes
    ply,  ///< binary little-endian; doubles; UVs per face corner (texcoord), material_index and group_index per face
    glb,  ///< glTF 2.0 binary; floats about a local origin, split at UV seams, one node per group
};

/// The format of a file name's extension, in upper or lower case.
/// @throws Error unsupported: another extension or none
MeshFormat mesh_format(const std::filesystem::path& path);

/// Writes a TriangleMesh or PolygonMesh in the format of the path's extension. The file appears whole or not at all
/// (see AtomicFile), with the same bytes for any number of threads. Vertices keep their order and are never merged. PLY
/// and GLB have one normal per vertex, so copies of vertices on creases follow after all vertices; GLB also has copies
/// at UV seams. Polygons in GLB are cut into triangles by the rule of triangulate().
/// @throws Error  unsupported (extension; more than 4 GiB of GLB), invalid_input (the mesh contradicts itself or has a
///                number that is not finite), io (with the reason), cancelled
void write_mesh(const std::filesystem::path& path, const MeshView& mesh, const RunContext& context = {});
/// The same into a file that the caller commits, alone or together with others (FileSet).
void write_mesh(AtomicFile& file, const MeshView& mesh, const RunContext& context = {});
/// The same for a part of a model: GLB uses the local origin of the whole model, so vertices that parts share have the
/// same floats in all of them.
/// @param whole  bounding box of the whole model
void write_mesh_part(AtomicFile& file, const MeshView& mesh, const Box3d& whole, const RunContext& context = {});

/// The local origin of a GLB: its nodes' translation, exact in float. Zero if the model is near the origin.
Vec3d glb_origin(const Box3d& box);

/// Upper bound on how far GLB moves the vertices of a model with this bounding box: coordinates are rounded to float
/// relative to glb_origin().
double glb_rounding_bound(const Box3d& box);

/// The same for every model whose bounding box is inside `box`.
double glb_rounding_bound_within(const Box3d& box);

}  // namespace tetrakis
