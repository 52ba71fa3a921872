#pragma once

#include "../../hier/base/vec.hpp"
#include "view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tetrakis::detail {

/// The camera as decisions need it.
struct Eye {
    Vec3d at{}, forward{0, 1, 0}, right{1, 0, 0}, up{0, 0, 1};
    std::array<Vec3d, 4> sides{};         ///< of the frustum: unit normals to the inside
    double side_sin = 0, side_cos = 1;    ///< of half the horizontal field of view
    double above_sin = 0, above_cos = 1;  ///< of half the vertical one
    double pixels = 0;                    ///< of something of length 1 at distance 1

    explicit Eye(const lod::Camera& camera) : at(camera.eye), forward(unit(camera.direction)) {
        right = glm::cross(forward, camera.up);
        if (!(glm::length(right) > 1e-9 * glm::length(camera.up)))
            right = glm::cross(forward, std::abs(forward.x) < 0.5 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0));
        right = glm::normalize(right);
        up = glm::cross(right, forward);
        const double y = std::tan(camera.vertical_fov / 2), x = y * camera.width / camera.height;
        pixels = camera.height / (2 * y);
        side_cos = 1 / std::hypot(1, x), side_sin = x * side_cos;
        above_cos = 1 / std::hypot(1, y), above_sin = y * above_cos;
        sides = {side_sin * forward + side_cos * right, side_sin * forward - side_cos * right,
                 above_sin * forward + above_cos * up, above_sin * forward - above_cos * up};
    }
    /// Of any length, as large or small as it may be.
    static Vec3d unit(const Vec3d& v) {
        return glm::normalize(v / std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}));
    }
    /// How far a box, relative to the eye, is inside the nearest side of the frustum; where it is beside, less than 0.
    double inside(const Vec3d& center, const Vec3d& half_sides) const {
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < sides.size(); ++k)
            least = std::min(least, glm::dot(center, sides[k]) + glm::dot(half_sides, glm::abs(sides[k])));
        return least;
    }
    bool has_opening_of(const Eye& other) const {
        return side_sin == other.side_sin && above_sin == other.above_sin && pixels == other.pixels;
    }
    /// The angle between two of them.
    double turn_to(const Eye& other) const {
        const Vec3d f = other.forward - forward, r = other.right - right, u = other.up - up;
        return 2 * std::asin(std::min(1.0, std::sqrt((glm::dot(f, f) + glm::dot(r, r) + glm::dot(u, u)) / 8)));
    }
};

}  // namespace tetrakis::detail
