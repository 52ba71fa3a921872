#pragma once

#include "../rules/limit_point.hpp"

#include <glm/geometric.hpp>

namespace tetrakis::detail {

/// A frame from a position, a sum of normals by area and a direction from the position to a neighbour.
inline LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards) {
    LimitPoint result;
    result.position = position;
    const double length = glm::length(area_normal);
    if (!(length > 0)) return result;
    result.normal = area_normal / length;
    result.tangent1 = towards - glm::dot(towards, result.normal) * result.normal;
    result.tangent2 = glm::cross(result.normal, result.tangent1);
    result.has_tangent_plane = true;
    return result;
}

}  // namespace tetrakis::detail
