#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

namespace tetrakis {

/// Splits each triangle in four at the midpoints of its edges: the surface is the control mesh itself.
/// @throws std::invalid_argument  a face is no triangle
RuleStep midpoint_step(const RuleMesh& mesh, const RuleOptions& options);
/// Splits each k-gon in k quads at edge midpoints and the mean of its corners; quads become bilinear patches.
RuleStep bilinear_step(const RuleMesh& mesh, const RuleOptions& options);
/// The limit is the vertex itself; there is no formula for tangents.
ClosedMasks linear_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
