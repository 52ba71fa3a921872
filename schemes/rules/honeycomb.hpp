#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

namespace tetrakis {

/// The honeycomb refinement (the refinement rule of Dyn, Levin, Liu 1992) with an approximating mask of our own, as
/// theirs is not stationary. A k-gon gets a k-gon in its middle, an edge a hexagon; on hexagons this gives four times
/// as many, half as large and not turned. New points: the old vertices, then one per half-edge (the corner at its
/// origin), then one per sharp edge.
///
/// The corner of the middle k-gon takes Doo-Sabin's weights, whose eigenvalues for every k are 1, 1/2 twice, 1/4: on
/// hexagons they reproduce the plane, and no k-gon has another eigenvalue above 1/4; but the hexagons around it have,
/// 7/24 (0.2917), so that curvatures are not bounded. An old vertex goes to the mean of
/// the new corners around it. Boundary and crease: cubic B-spline; corner: stays.
RuleStep honeycomb_step(const RuleMesh& mesh, const RuleOptions& options);
/// At the centre of a face, or at a boundary vertex. Of its faces, one more after each step, those along the boundary
/// are pentagons, which map to themselves and each to its own half of the boundary.
ClosedMasks honeycomb_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
