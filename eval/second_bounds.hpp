#pragma once

#include "tetrakis/eval/bicubic.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

/// Where the second derivatives of a patch lie: balls around three vectors, and the largest norms along the axes.
struct SecondBounds {
    Vec3d uu{0}, uv{0}, vv{0};  ///< centres
    double radius_uu = 0, radius_uv = 0, radius_vv = 0;
    double max_uu = 0, max_vv = 0;

    /// Bound on the norm of the second derivative along (a, b).
    double along(double a, double b) const {
        if (b == 0) return a * a * max_uu;
        if (a == 0) return b * b * max_vv;
        const Vec3d centre = (a * a) * uu + (2 * a * b) * uv + (b * b) * vv;
        return std::sqrt(glm::dot(centre, centre)) + a * a * radius_uu + 2 * std::abs(a * b) * radius_uv +
               b * b * radius_vv;
    }

    /// Of a bicubic patch on [0, 1 / scale_x] x [0, 1 / scale_y]: its second differences are B-spline control vectors
    /// of the second derivatives, whose convex hull holds them.
    static SecondBounds of(const Net16& net, double scale_x = 1, double scale_y = 1);
};

/// Bound on the deviation of a surface from the linear interpolant on a triangle: edge k's second derivative along the
/// whole edge is at most m[k]. Through a point draw the line parallel to edge k: its ends lie on the other two edges,
/// at the fraction s from their common corner, so the deviation is at most s (1 - s) / 2 max(m_i, m_j) + s^2 / 8 m_k;
/// take the best k.
inline double triangle_deviation(double m0, double m1, double m2) {
    const auto with = [](double sides, double line) {
        return line >= 2 * sides ? line / 8 : sides * sides / (8 * sides - 2 * line);
    };
    return std::min({with(std::max(m1, m2), m0), with(std::max(m0, m2), m1), with(std::max(m0, m1), m2)});
}

}  // namespace tetrakis::detail
