#include "star_norms.hpp"

#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

/// Least squares.
void StarNorms::find_fit() {
    glm::dmat3 normal(0);
    for (const Vec2d& p : reference_) normal += glm::outerProduct(Vec3d(1, p.x, p.y), Vec3d(1, p.x, p.y));
    for (const Vec2d& p : reference_) fit_.push_back(glm::inverse(normal) * Vec3d(1, p.x, p.y));
}

double StarNorms::deviation(std::span<const Vec3d> points, int triangle) const {
    Vec3d at(0), x(0), y(0);
    for (std::size_t i = 0; i < fit_.size(); ++i) {
        at += fit_[i].x * points[i];
        x += fit_[i].y * points[i];
        y += fit_[i].z * points[i];
    }
    // The affine map stretches by the larger singular value of its matrix at most.
    const double xx = glm::dot(x, x), yy = glm::dot(y, y), xy = glm::dot(x, y);
    const double stretch = std::sqrt(0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy));
    const Triangle& of = triangles_[static_cast<std::size_t>(triangle)];
    double sum = stretch * of.reference_deviation;
    for (std::size_t i = 0; i < fit_.size(); ++i)
        sum += of.norm[i] * glm::length(points[i] - (at + reference_[i].x * x + reference_[i].y * y));
    return sum * k_rounding_of_sums;
}

}  // namespace tetrakis::detail
