#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <array>

namespace tetrakis {

/// Repeated averaging (Zorin, Schroeder 2001; Warren, Weimer; Stam 2001): every k-gon in k quads, then m times each
/// quad's centroid becomes a vertex. m = 0 bilinear, 1 Doo-Sabin with Catmull and Clark's weights, 2 nearly
/// Catmull-Clark, 3 biquartic; on quads the tensor product B-spline of degree m + 1. Even m: primal, odd m: dual.
///
/// Boundary, AveragingBoundary::replicate: m = 2 takes the cubic B-spline; the others see copies of the boundary
/// vertices around the mesh, as many layers as they reach (m <= 4 one; a tagged corner with one face sees a quad of
/// copies of itself as well). AveragingBoundary::recede: only what needs no missing point is made, so the control
/// mesh's outer ring (two from m = 5 on) is used up and the surface ends inside. Creases have no rule here: tags inside
/// the mesh are ignored.
/// @throws std::invalid_argument  steps < 0, or nothing of the mesh is left
RuleStep averaging_step(const RuleMesh& mesh, const RuleOptions& options);
/// averaging_step() with three steps.
RuleStep biquartic_step(const RuleMesh& mesh, const RuleOptions& options);
ClosedMasks averaging_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks biquartic_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
