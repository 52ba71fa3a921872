#pragma once

#include <algorithm>

namespace tetrakis::detail {

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
