#pragma once

#include "../rules/limit_point.hpp"

#include <glm/geometric.hpp>

#include <cmath>

namespace tetrakis::detail {

/// A frame from a position, a sum of normals by area and a direction from the position to a neighbour; any direction
/// across the normal where that one is along it.
inline LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards) {
    LimitPoint result;
    result.position = position;
    const double length = glm::length(area_normal);
    if (!(length > 0)) return result;
    result.normal = area_normal / length;
    result.tangent1 = towards - glm::dot(towards, result.normal) * result.normal;
    constexpr double k_along = 1e-12;  // of a direction along the normal rounding is left
    if (!(glm::length(result.tangent1) > k_along * glm::length(towards))) {
        const Vec3d across = std::abs(result.normal.x) < 0.9 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
        result.tangent1 = glm::cross(across, result.normal);
    }
    result.tangent2 = glm::cross(result.normal, result.tangent1);
    result.has_tangent_plane = true;
    return result;
}

}  // namespace tetrakis::detail
