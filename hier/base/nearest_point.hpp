#pragma once

#include "vec.hpp"

#include <algorithm>
#include <limits>

namespace tetrakis::detail {

/// The point a + u (b - a) + v (c - a) of a triangle and its squared distance from the query point.
struct TrianglePoint {
    Vec3d point{0.0};
    double squared_distance = std::numeric_limits<double>::infinity();
    double u = 0, v = 0;
};

/// Parameter in [0, 1] of the point of the segment from 0 to `edge` that is nearest to `offset`.
inline double nearest_on_segment(const Vec3d& edge, const Vec3d& offset) {
    const double length_squared = glm::dot(edge, edge);
    return length_squared > 0 ? std::clamp(glm::dot(edge, offset) / length_squared, 0.0, 1.0) : 0.0;
}

/// Nearest point of the triangle (a, b, c). The result is always a point of the triangle, so only rounding can make the
/// distance too small; degenerate triangles count as the segments or the point that they are.
inline TrianglePoint nearest_on_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d ab = b - a, ac = c - a, ap = p - a;
    const Vec3d normal = glm::cross(ab, ac);
    const double normal_squared = glm::dot(normal, normal);
    const double sides_squared = glm::dot(ab, ab) * glm::dot(ac, ac);
    TrianglePoint best;
    const auto offer = [&](double u, double v) {
        const Vec3d at = u * ab + v * ac, gap = ap - at;
        const double squared = glm::dot(gap, gap);
        if (squared < best.squared_distance) best = {a + at, squared, u, v};
    };
    // sin^2 of the angle at a. Below the first bound rounding leaves nothing of the normal; below the second one the
    // barycentric coordinates lose half their digits, which a step of iterative refinement brings back.
    constexpr double k_degenerate = 1e-24, k_sliver = 1e-8;
    const bool degenerate = !(normal_squared > k_degenerate * sides_squared);
    const bool sliver = !(normal_squared > k_sliver * sides_squared);
    double u = 0, v = 0;
    if (!degenerate) {
        u = glm::dot(glm::cross(ap, ac), normal) / normal_squared;
        v = glm::dot(glm::cross(ab, ap), normal) / normal_squared;
        if (sliver) {
            const Vec3d rest = ap - (u * ab + v * ac);
            u += glm::dot(glm::cross(rest, ac), normal) / normal_squared;
            v += glm::dot(glm::cross(ab, rest), normal) / normal_squared;
        }
        if (u >= 0 && v >= 0 && u + v <= 1) {
            offer(u, v);
            if (!sliver) return best;
        }
    }
    // If the projection is outside, the nearest point is on an edge that separates the two; slivers try all edges.
    if (sliver || v < 0) offer(nearest_on_segment(ab, ap), 0);
    if (sliver || u < 0) offer(0, nearest_on_segment(ac, ap));
    if (sliver || u + v > 1) {
        const double t = nearest_on_segment(c - b, p - b);
        offer(1 - t, t);
    }
    return best;
}

/// Distance from a point to a segment.
inline double segment_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d edge = b - a, offset = p - a;
    return glm::length(offset - nearest_on_segment(edge, offset) * edge);
}

}  // namespace tetrakis::detail
