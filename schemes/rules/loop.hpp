#pragma once

#include "../core/ring_mask.hpp"

#include <string_view>

namespace tetrakis {

/// Loop subdivision of triangle meshes. Sources: Loop 1987 (rules); Hoppe et al. 1994 (creases, limits); Warren 1995
/// (the simpler weights). No face points: RingMask::face is 0.
struct Loop {
    static constexpr std::string_view name = "loop";

    /// Smooth edge rule: each end, each opposite corner.
    static constexpr double edge_end = 3.0 / 8, edge_opposite = 1.0 / 8;

    /// Loop's weight of each neighbour: (5/8 - (3/8 + cos(2 pi / n) / 4)^2) / n, for n >= 1.
    static double beta(int valence);
    /// Warren's: 3 / (8n) for n > 3, 3/16 for n <= 3. Offered beside Loop's, which is the default everywhere.
    static double beta_warren(int valence);

    /// Moves an interior smooth (or dart) vertex of valence n >= 1, with Loop's weights.
    static RingMask vertex_mask(int valence) { return vertex_mask(valence, beta(valence)); }
    /// The same with any beta.
    static RingMask vertex_mask(int valence, double beta) { return {.vertex = 1 - valence * beta, .edge = beta}; }
    /// Limit position of an interior smooth vertex: chi = 1 / (3 / (8 beta) + n) for each neighbour.
    static RingMask limit_mask(int valence) { return limit_mask(valence, beta(valence)); }
    static RingMask limit_mask(int valence, double beta);
    /// Eigenvalue of the mode of angle `angle` (2 pi k / n in the interior, pi k / K beside a boundary or crease):
    /// 3/8 + cos(angle) / 4; the subdominant one is at k = 1.
    static double mode_eigenvalue(double angle);
};

}  // namespace tetrakis
