#pragma once

#include "../core/closed_masks.hpp"
#include "../core/rule_step.hpp"

namespace tetrakis {

/// One step of Loop's scheme with every rule it has: smooth, crease and boundary, corner, dart, semi-sharp.
///
/// Options: Warren's weights; the C1 edge rule beside creases (Biermann, Levin, Zorin 2000: with K faces on the
/// side of the crease vertex c and theta = pi / K the edge point is (3/4 - g) c + g e + 1/8 of both opposite corners,
/// g = 1/2 - cos(theta) / 4), for theta -> 0 its brief form g = 1/4, used where the plain rule fails; Hoppe's crease
/// rule; sectors of corners with an angle alpha (RuleMesh::corner_angle() or the option): theta = alpha / K, and for
/// alpha > pi the flatness step, which pulls the new ring towards the affine image of the corner's own fan, so far that
/// every other mode of the ring has at most 1/4.
/// @throws std::invalid_argument  a face is no triangle; the corner angle is not in [0, 2 pi) or is pi
RuleStep loop_step(const RuleMesh& mesh, const RuleOptions& options);

/// The masks that have closed forms; see ClosedMasks.
ClosedMasks loop_closed_masks(const FanShape& shape, const RuleOptions& options);

namespace detail {

/// Loop's edge rules, which its relatives share: a crease edge, a smooth edge.
StencilRow loop_crease_edge_row(const RuleMesh& mesh, int halfedge, const RuleOptions& options);
StencilRow loop_smooth_edge_row(const RuleMesh& mesh, int halfedge, const RuleOptions& options);

}  // namespace detail
}  // namespace tetrakis
