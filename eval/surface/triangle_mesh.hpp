#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tetrakis {

/// An indexed triangle mesh with shared vertices, for tessellations, targets and comparisons. It has V vertices and T
/// triangles; empty optional arrays mean "none".
struct TriangleMesh {
    std::vector<Vec3d> positions;  ///< V points
    std::vector<std::array<std::uint32_t, 3>>
        triangles;               ///< T triples of vertex numbers, counter-clockwise from outside
    std::vector<Vec3d> normals;  ///< unit normals: V, one a vertex, where triangle_normals is empty; or empty
    /// T triples into `normals`, or empty. Vertices on creases have several, one for each side.
    std::vector<std::array<std::uint32_t, 3>> triangle_normals;
    std::vector<Vec2d> uvs;                                  ///< U distinct texture coordinates, or empty
    std::vector<std::array<std::uint32_t, 3>> triangle_uvs;  ///< T triples into `uvs`, or empty
    std::vector<std::uint32_t> triangle_material;            ///< T numbers into `materials`, or empty
    std::vector<std::string> materials;
    std::vector<std::uint32_t> triangle_group;  ///< T numbers into `groups`, or empty
    std::vector<std::string> groups;
};

}  // namespace tetrakis
