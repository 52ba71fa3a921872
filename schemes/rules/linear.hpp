#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

namespace tetrakis {

/// Each triangle in four at its edges' midpoints: the control mesh itself.
/// @throws std::invalid_argument  a face is no triangle
RuleStep midpoint_step(const RuleMesh& mesh, const RuleOptions& options);
/// Each k-gon in k quads at midpoints and the mean of its corners; quads become bilinear patches.
RuleStep bilinear_step(const RuleMesh& mesh, const RuleOptions& options);
/// The vertex itself, and no formula for tangents.
ClosedMasks linear_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
