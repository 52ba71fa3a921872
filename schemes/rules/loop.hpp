#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <functional>

namespace tetrakis {

/// Loop subdivision of triangle meshes. Sources: Loop 1987 (rules); Hoppe et al. 1994 (creases, limits); Warren 1995
/// (the simpler weights). No face points: RingMask::face is 0.
struct Loop {
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

/// One step of Loop's scheme, with rules for smooth, crease, boundary, corner, dart and semi-sharp.
///
/// Options: Warren's weights; Hoppe's crease rule; the C1 edge rule beside creases (Biermann, Levin, Zorin 2000). With
/// K faces on the side of the crease vertex c and theta = pi / K, its edge point is (3/4 - g) c + g e + 1/8 of both
/// opposite corners, g = 1/2 - cos(theta) / 4. The brief form, g = 1/4 (theta -> 0), is used where the plain rule
/// fails. Sectors of corners may have an angle alpha (RuleMesh::corner_angle() or the option): then theta = alpha / K.
/// If alpha > pi, the flatness step pulls the new ring towards the affine image of the corner's own fan, so far that
/// every other mode of the ring has an eigenvalue of at most 1/4.
/// @throws std::invalid_argument  a face is no triangle; the corner angle is not in [0, 2 pi) or is pi
RuleStep loop_step(const RuleMesh& mesh, const RuleOptions& options);

/// The masks that have closed forms; see ClosedMasks.
ClosedMasks loop_closed_masks(const FanShape& shape, const RuleOptions& options);

namespace detail {

/// A step of Loop's scheme, or of one with the same rules at boundaries, creases and corners.
/// @param beta         (valence) to the weight of each neighbour
/// @param smooth_edge  (half-edge) to the row of a smooth edge; called by many threads at once
RuleStep loop_like_step(const RuleMesh& mesh, const RuleOptions& options, const char* name, bool chaikin,
                        const std::function<double(int)>& beta, const std::function<StencilRow(int)>& smooth_edge);
StencilRow loop_smooth_edge_row(const RuleMesh& mesh, int halfedge, const RuleOptions& options);

}  // namespace detail
}  // namespace tetrakis
