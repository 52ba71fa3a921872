#pragma once

#include "rule_mesh.hpp"

#include <numbers>
#include <span>
#include <vector>

namespace tetrakis {

/// An angle by which a corner's rules work well: at most 350 degrees, and 170 for all nearer to 180 than 10: the
/// flatness step divides by the angle's sine.
double usable_corner_angle(double angle);

namespace detail {

inline bool is_corner_angle(double angle) {
    return angle > 0 && angle < 2 * std::numbers::pi && angle != std::numbers::pi;
}

/// RuleMesh::corner_angle() of a finer mesh whose vertices keep theirs. Where an edge between two sectors goes smooth,
/// the one that is left has the usable sum of their angles, or none if one of them had none.
/// @param child  of each half-edge the finer one that leaves the same vertex in its face
/// @param fine   half-edges of the finer mesh
std::vector<double> child_corner_angles(const RuleMesh& mesh, std::span<const int> child, std::size_t fine);

}  // namespace detail
}  // namespace tetrakis
