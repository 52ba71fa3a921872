#pragma once

#include "../../hier/base/run_context.hpp"
#include "../surface/triangle_mesh.hpp"

#include <filesystem>

namespace tetrakis {

/// Reads a triangle mesh for comparison, projection or drawing: .obj, .ply (text and both binary orders), .glb, .gltf.
/// Polygons are cut by the rule of triangulate(). Vertices stay as they are in the file, with one exception: glTF and
/// PLY with normals split vertices at seams and creases, so vertices at the same position are joined.
/// Normals are kept if each corner has one, UVs if each face has them. Tags and curves of OBJ are ignored. For control
/// meshes use load_control_mesh(), which reads the tags and checks the topology.
/// @throws Error io (missing, unreadable), unsupported (another format, compressed or sparse glTF), memory_limit,
///         invalid_input, with the line of a text file or the byte offset of a binary one: truncated or malformed data,
///         no faces, an index out of range, a coordinate that is not finite
TriangleMesh read_triangle_mesh(const std::filesystem::path& path, const RunContext& context = {});

}  // namespace tetrakis
