#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cmath>
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

/// Nearest point of the triangle (a, b, c). Always a point of the triangle, so the distance is never too small but for
/// rounding; degenerate triangles count as the segments or the point that they are.
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
    // Outside, the nearest point lies on an edge that the projection is beyond of; near-degenerate: try them all.
    if (sliver || v < 0) offer(nearest_on_segment(ab, ap), 0);
    if (sliver || u < 0) offer(0, nearest_on_segment(ac, ap));
    if (sliver || u + v > 1) {
        const double t = nearest_on_segment(c - b, p - b);
        offer(1 - t, t);
    }
    return best;
}

/// Distance of surface samples to a triangle as the mesh sees it: to the triangle's plane where the sample stands over
/// the triangle or a little beside it (there the neighbour, nearly in the same plane, takes over), else to the triangle
/// itself.
class PlaneMeasure {
  public:
    explicit PlaneMeasure(const std::array<Vec3d, 3>& corners) : corners_(corners) {
        const Vec3d u = corners[1] - corners[0], v = corners[2] - corners[0];
        const Vec3d n = glm::cross(u, v);
        const double length = glm::length(n);
        flat_ = length > 0;
        if (!flat_) return;
        normal_ = n / length;
        // Rows that give the barycentrics of a point's projection.
        to_b1_ = glm::cross(v, normal_) / length;
        to_b2_ = glm::cross(normal_, u) / length;
    }
    const Vec3d& normal() const { return normal_; }
    bool flat() const { return flat_; }

    /// A point seen from the plane: barycentrics of its foot, and how far above it stands. Needs flat().
    struct Projection {
        double b1, b2, height;
    };
    Projection project(const Vec3d& p) const {
        const Vec3d d = p - corners_[0];
        return {glm::dot(to_b1_, d), glm::dot(to_b2_, d), glm::dot(normal_, d)};
    }

    double operator()(const Vec3d& p) const {
        if (flat_) {
            const Vec3d d = p - corners_[0];
            const double b1 = glm::dot(to_b1_, d), b2 = glm::dot(to_b2_, d);
            if (b1 > -k_beside && b2 > -k_beside && b1 + b2 < 1 + k_beside) return std::abs(glm::dot(normal_, d));
        }
        return std::sqrt(nearest_on_triangle(p, corners_[0], corners_[1], corners_[2]).squared_distance);
    }

  private:
    /// How far beside its triangle a sample may stand, in barycentrics (measured: a quarter saves a fifth of the
    /// triangles).
    static constexpr double k_beside = 0.25;
    std::array<Vec3d, 3> corners_;
    Vec3d normal_{0}, to_b1_{0}, to_b2_{0};
    bool flat_ = false;
};

/// Distance from a point to a segment.
inline double segment_distance(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
    const Vec3d edge = b - a, offset = p - a;
    return glm::length(offset - nearest_on_segment(edge, offset) * edge);
}

}  // namespace tetrakis::detail
