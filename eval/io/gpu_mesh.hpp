#pragma once

#include "../../hier/base/vec.hpp"
#include "../surface/triangle_mesh.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis {

/// A triangle mesh as graphics cards draw it: floats, and one index for position, normal and UV.
struct GpuMesh {
    std::vector<Vec3f> positions;         ///< relative to `origin`
    std::vector<Vec3f> normals;           ///< unit normals, one a position; or empty
    std::vector<glm::vec2> uvs;           ///< one a position, (0, 0) where no triangle has any; or empty
    std::vector<std::uint32_t> indices;   ///< three a triangle, in the order of the mesh
    std::vector<std::uint32_t> vertices;  ///< per position: its vertex in the mesh
    Vec3d origin{0};                      ///< add it to positions, in double, for the mesh's coordinates
};

/// Converts a mesh for a graphics card. Vertices with several normals or UVs (creases, seams) get a copy for each
/// further pair. Copies come after all vertices and have the same position bits, so there are no cracks.
/// @param origin  subtracted before rounding to float: choose a point near models that are far from zero (glb_origin())
/// @throws Error  invalid_input: the mesh contradicts itself, or a coordinate minus `origin` does not fit in a float;
///                unsupported: 2^32 - 1 positions or more
/// Cost: O(V + T) times the number of normals and UVs of a vertex, one thread.
GpuMesh gpu_mesh(const TriangleMesh& mesh, const Vec3d& origin = Vec3d(0));

}  // namespace tetrakis
