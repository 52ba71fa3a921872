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
    std::vector<std::uint32_t> vertices;  ///< per position: the vertex of the mesh that it is
    Vec3d origin{0};                      ///< to be added to all positions, in double
};

/// Vertices with several normals or UVs (creases, seams) get a copy for each; copies come after all vertices. Their
/// positions are equal to the bit, so no crack opens.
/// @param origin  subtracted before rounding to float: choose one near models that are far from zero (glb_origin())
/// @throws Error  invalid_input: the mesh contradicts itself, or floats cannot hold a coordinate of it less the origin;
///                unsupported: 2^32 - 1 positions or more
/// Cost: O(V + T) times the normals and UVs that a vertex has, one thread.
GpuMesh gpu_mesh(const TriangleMesh& mesh, const Vec3d& origin = Vec3d(0));

}  // namespace tetrakis
