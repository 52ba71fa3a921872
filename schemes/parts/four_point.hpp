#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis::detail {

/// Weights of the four-point rule (Dyn, Gregory, Levin 1987, w = 1/16).
inline constexpr double k_four_point_end = 9.0 / 16, k_four_point_far = -1.0 / 16;

/// The four-point rule on a crease or boundary edge, along the crease. Where the crease ends (corner, dart) the missing
/// point is 2 p_0 - p_1: (7, 10, -1) / 16.
inline StencilRow four_point_edge(const RuleMesh& mesh, int h) {
    const int u = mesh.origin(h), v = mesh.target(h);
    StencilRow row{{u, k_four_point_end}, {v, k_four_point_end}};
    for (const auto& [at, from] : {std::pair(u, v), std::pair(v, u)}) {
        const auto sharp = mesh.sharp_neighbours(at);
        if (sharp.size() == 2 && mesh.rule(at) == VertexRule::crease) {
            row.add(sharp[0] == from ? sharp[1] : sharp[0], k_four_point_far);
        } else {
            row.add(at, 2 * k_four_point_far);
            row.add(from, -k_four_point_far);
        }
    }
    return row;
}

/// Tangent at a vertex along a row of points, which leaves the vertex along the rays `ahead` and `behind`.
inline ClosedMasks::Mask four_point_tangent(int ahead, int behind) {
    return {{{ahead, 2, 0}, -1}, {{ahead, 1, 0}, 8}, {{behind, 1, 0}, -8}, {{behind, 2, 0}, 1}};
}

}  // namespace tetrakis::detail
