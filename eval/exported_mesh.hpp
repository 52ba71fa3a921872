#pragma once

#include "tetrakis/eval/local_frame.hpp"
#include "tetrakis/eval/output_triangle.hpp"
#include "tetrakis/eval/tessellate.hpp"
#include "tetrakis/hier/exported_triangles.hpp"
#include "tetrakis/hier/fan_choice.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace tetrakis::detail {

/// What a refined hierarchy looks like from outside, and where each of its triangles comes from.
template <class Family>
struct ExportedMesh : ExportedTriangles {
    using Hierarchy = typename Family::Hierarchy;

    std::vector<std::uint8_t> part;  ///< which of its leaf's or fan's triangles each is

    ExportedMesh() = default;
    /// @param fans  of which the hierarchy has accepted some; empty where it has none
    ExportedMesh(const Hierarchy& hierarchy, const FanChoice& fans)
        : ExportedTriangles(triangles_of(hierarchy, fans)), part(triangles.size(), 0) {
        // A fan's or a green leaf's triangles stand next to each other.
        for (std::size_t t = 1; t < part.size(); ++t)
            if (leaves[t - 1] == leaves[t] && (leaves[t].valid() || faces[t - 1] == faces[t]))
                part[t] = static_cast<std::uint8_t>(part[t - 1] + 1);
    }

    OutputTriangle origin(const Hierarchy& hierarchy, const FanChoice& fans, std::uint32_t t) const {
        OutputTriangle from;
        if (leaves[t].valid()) {
            std::array<CellTriangle, 3> parts;
            hierarchy.triangles(leaves[t], parts);
            from.cell = parts[part[t]];
            return from;
        }
        from.fan = faces[t];
        const auto corners = fans.of(from.fan)[part[t]];
        for (std::size_t k = 0; k < 3; ++k) from.fan_corner[k] = corners[k];
        return from;
    }

    /// Tells the result the face and the error of each triangle, and the deepest level.
    template <class Refinement>
    void describe(const Hierarchy& hierarchy, const Refinement& refinement, Tessellation& result) const {
        const std::size_t count = leaves.size();
        result.triangle_face.resize(count);
        result.triangle_error.resize(count);
        result.deepest_level = 0;
        for (std::size_t t = 0; t < count; ++t) {
            const LeafId leaf = leaves[t];
            result.triangle_face[t] = faces[t].value;
            result.triangle_error[t] = round_up(leaf.valid() ? refinement.error(leaf) : hierarchy.fan_error(faces[t]));
            if (leaf.valid()) result.deepest_level = std::max(result.deepest_level, hierarchy.level(leaf));
        }
    }

  private:
    static ExportedTriangles triangles_of(const Hierarchy& hierarchy, const FanChoice& fans) {
        if constexpr (std::is_same_v<Family, QuadFamily>)
            if (!fans.offsets.empty()) return hierarchy.forest().exported(fans, hierarchy.fans());
        return hierarchy.forest().exported();
    }
};

}  // namespace tetrakis::detail
