#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// The errors of faces' fans (eval/README.md) over a surface that is known by its limit points, as LimitEstimator finds
/// those of triangles: limit points over all of the face to the nearest triangle of its fan, and back; hard edges to
/// themselves. 0 for faces without a fan.
/// @param points            of the bisection family
/// @param corner_positions  of the control vertices in the output
std::vector<double> fan_limit_errors(const Hierarchy& points, const FanChoice& fans,
                                     std::span<const Vec3d> corner_positions, const RunContext& context);

}  // namespace tetrakis::detail
