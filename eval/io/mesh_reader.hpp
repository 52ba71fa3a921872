#pragma once

#include "../../hier/base/run_context.hpp"
#include "../surface/triangle_mesh.hpp"

#include <filesystem>

namespace tetrakis {

/// Reads a triangle mesh to compare with, project onto or draw: .obj, .ply (text and both binary orders), .glb, .gltf.
/// Polygons are cut by the rule of triangulate(). Vertices stay as they are in the file; of a glTF, or of a PLY with
/// normals, whose vertices are split wherever normals or UVs are, those in the same place become one again. Normals are
/// kept where each corner has one, UVs where each face has them; OBJ tags and curves are passed over.
/// Control meshes are read by hier's reader instead, which knows the tags and checks the topology.
/// @throws Error io (missing, unreadable), unsupported (another format, compressed or sparse glTF), memory_limit,
///         invalid_input: with the line of a text file or the byte offset of a binary one: truncated or malformed data,
///         no faces, an index out of range, a coordinate that is not finite
TriangleMesh read_triangle_mesh(const std::filesystem::path& path, const RunContext& context = {});

}  // namespace tetrakis
