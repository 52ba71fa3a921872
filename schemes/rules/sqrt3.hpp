#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

namespace tetrakis {

/// Kobbelt's sqrt(3) scheme (Kobbelt 2000): a vertex in every triangle, then every old edge is flipped.
struct Sqrt3 {
    /// (4 - 2 cos(2 pi / n)) / 9: makes the rotation-symmetric eigenvalue of two steps the square of the subdominant
    /// one.
    static double alpha(int valence);
    static RingMask vertex_mask(int valence);
    static RingMask limit_mask(int valence);
    /// Boundary and crease, every second step: the ternary cubic B-spline. Near vertex p_i from p_(i-1), p_i, p_(i+1):
    /// the new points before it, at it and after it are (10, 16, 1), (4, 19, 4), (1, 16, 10) over 27.
    static constexpr double crease_near = 10.0 / 27, crease_middle = 16.0 / 27, crease_far = 1.0 / 27;
    static constexpr double crease_vertex = 19.0 / 27, crease_neighbour = 4.0 / 27;
};

/// Two steps at once, so that the mesh is not turned: every edge in three, every triangle in nine. The first step does
/// not flip boundary and crease edges nor move their vertices; the second cuts these edges in three. A corner stays,
/// and the crease points beside it continue the crease straight: (2/3, 1/3). New points: old vertices, then those of
/// the first step (one per triangle), then those of the second.
/// @throws std::invalid_argument  a face is no triangle
RuleStep sqrt3_step(const RuleMesh& mesh, const RuleOptions& options);
ClosedMasks sqrt3_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
