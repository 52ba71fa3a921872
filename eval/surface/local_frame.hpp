#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrakis::detail {

/// A box's own frame for float computations: the origin at its centre, scaled by a power of two (hence exactly) so that
/// its largest half extent lies in [1/2, 1]. Floats in it resolve the box to about 6e-8, wherever it is and however
/// big.
struct LocalFrame {
    Vec3d origin{0.0};
    double scale = 1;

    static LocalFrame of(const Box3d& box) { return around(0.5 * box.lower + 0.5 * box.upper, box); }
    /// The same with its origin at a point of the box.
    static LocalFrame around(const Vec3d& origin, const Box3d& box) {
        LocalFrame frame;
        if (box.empty()) return frame;
        frame.origin = origin;
        const Vec3d reach = glm::max(box.upper - origin, origin - box.lower);
        const double extent = std::max({reach.x, reach.y, reach.z});
        // Beyond these exponents the scale itself would leave the range of double.
        constexpr int k_largest_exponent = 1020;
        if (extent > 0) frame.scale = std::scalbn(1.0, std::min(-std::ilogb(extent) - 1, k_largest_exponent));
        return frame;
    }
    Vec3d to_local(const Vec3d& p) const { return (p - origin) * scale; }
    Vec3d to_world(const Vec3d& p) const { return p / scale + origin; }
};

/// The nearest floats below and above (an infinite float where the value is out of range).
inline float round_down(double x) {
    const float f = static_cast<float>(x);
    return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
inline float round_up(double x) {
    const float f = static_cast<float>(x);
    return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace tetrakis::detail
