#pragma once

#include "../../hier/base/vec.hpp"

#include <array>

namespace tetrakis::detail {

/// The quadratic over a triangle through its values at the corners and at the middles of the edges (middle k between
/// corners k and k + 1), as Bezier coefficients of its four quarters: their convex hull holds it.
///
/// Calls any(c) for each of them, and edge(k, c) besides for those on edge k (corners, middle and two between).
template <class Edge, class Any>
void for_each_coefficient(const std::array<Vec3d, 3>& corner, const std::array<Vec3d, 3>& middle, Edge&& edge,
                          Any&& any) {
    std::array<Vec3d, 3> control;  // Bezier coefficient of edge k
    for (std::size_t k = 0; k < 3; ++k) control[k] = 2.0 * middle[k] - 0.5 * (corner[k] + corner[(k + 1) % 3]);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const auto on_edge = [&](const Vec3d& c) {
            edge(k, c);
            any(c);
        };
        on_edge(corner[k]);
        on_edge(0.5 * (corner[k] + control[k]));
        on_edge(middle[k]);
        on_edge(0.5 * (control[k] + corner[next]));
        edge(k, corner[next]);
        any(0.25 * ((control[k] + control[next]) + (control[(k + 2) % 3] + corner[next])));
    }
}

}  // namespace tetrakis::detail
