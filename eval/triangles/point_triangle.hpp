#pragma once

#include "../../hier/base/nearest_point.hpp"

#include <array>
#include <cmath>

namespace tetrakis::detail {

/// Distance of surface samples to a triangle of a mesh. If the sample's foot is inside the triangle or a little
/// outside, it is the distance to the triangle's plane: a neighbour there lies nearly in the same plane. Otherwise it
/// is the distance to the triangle itself.
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

    double operator()(const Vec3d& p) const {
        if (flat_) {
            const Vec3d d = p - corners_[0];
            const double b1 = glm::dot(to_b1_, d), b2 = glm::dot(to_b2_, d);
            if (b1 > -k_beside && b2 > -k_beside && b1 + b2 < 1 + k_beside) return std::abs(glm::dot(normal_, d));
        }
        return std::sqrt(nearest_on_triangle(p, corners_[0], corners_[1], corners_[2]).squared_distance);
    }

  private:
    /// How far a sample's foot may lie outside the triangle, in barycentrics (measured: a quarter saves a fifth of the
    /// triangles).
    static constexpr double k_beside = 0.25;
    std::array<Vec3d, 3> corners_;
    Vec3d normal_{0}, to_b1_{0}, to_b2_{0};
    bool flat_ = false;
};

}  // namespace tetrakis::detail
