#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace tetrakis::detail {

/// A unit vector as two numbers (Meyer et al. 2010): 32767 is 1.
inline std::array<std::int16_t, 2> octahedral(const Vec3d& n) {
    const double sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    double x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
        const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
        y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
        x = folded;
    }
    return {static_cast<std::int16_t>(std::lround(32767 * x)), static_cast<std::int16_t>(std::lround(32767 * y))};
}

inline Vec3d from_octahedral(const std::array<std::int16_t, 2>& packed) {
    Vec3d n(packed[0] / 32767.0, packed[1] / 32767.0, 0);
    n.z = 1 - std::abs(n.x) - std::abs(n.y);
    if (n.z < 0) n = {(1 - std::abs(n.y)) * (n.x < 0 ? -1 : 1), (1 - std::abs(n.x)) * (n.y < 0 ? -1 : 1), n.z};
    return glm::normalize(n);
}

inline std::array<float, 3> packed(const Vec3d& v) {
    return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
inline Vec3d unpacked(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace tetrakis::detail
