#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_step.hpp"

#include <limits>

namespace tetrakis::detail {

/// No number: what is made from a point that is missing is missing.
inline constexpr Vec3d k_missing_point{std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN(),
                                       std::numeric_limits<double>::quiet_NaN()};

/// The mesh with one more ring of quads along its boundaries, for outer points that are missing: what a boundary that
/// recedes leaves (AveragingBoundary::recede) is what can be made without them. Vertices and faces keep their numbers,
/// the others come after; tags, texture coordinates and what belongs to faces stay behind. The first half-edge of each
/// quad is the twin of one of the mesh.
ControlMesh with_missing_ring(const ControlMesh& mesh);
/// By which such a mesh is refined: it has points all around, some of which are missing.
RuleOptions inside_missing_ring(RuleOptions rules);

}  // namespace tetrakis::detail
