#pragma once

#include "../../hier/forest/exported_triangles.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Where the vertices and triangles of an exported mesh were in the one before, which was refined in between.
struct MeshChange {
    static constexpr std::uint32_t k_new = 0xffffffffu;
    using Triangles = std::span<const std::array<std::uint32_t, 3>>;

    std::vector<std::uint32_t> vertex;    ///< number before, or k_new
    std::vector<std::uint32_t> triangle;  ///< number before, of one with the same corners; or k_new

    MeshChange() = default;
    /// @param triangles_before, triangles  of the two, in place of their own
    MeshChange(const ExportedTriangles& before, Triangles triangles_before, const ExportedTriangles& now,
               Triangles triangles);
};

}  // namespace tetrakis
