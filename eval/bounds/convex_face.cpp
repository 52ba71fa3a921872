#include "convex_face.hpp"

#include "plane_measure.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrakis::detail {

ConvexFace::ConvexFace(std::span<const Vec3d> corners) : corner_(corners.begin(), corners.end()) {
    Vec3d middle(0), area(0);
    for (const Vec3d& p : corners) middle += p / static_cast<double>(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
        area += glm::cross(corners[i] - middle, corners[(i + 1) % corners.size()] - middle);
    normal_ = unit_or_zero(area);
    for (Vec3d& p : corner_) {
        const double height = glm::dot(normal_, p - middle);
        height_ = std::max(height_, std::abs(height));
        p -= height * normal_;
    }
    convex_ = turns_once();
}

bool ConvexFace::turns_once() const {
    // To the left at each corner, and seen from the first one always on, so not around more than once.
    constexpr double k_least_sine = 1e-9;
    const std::size_t n = corner_.size();
    const auto turns = [&](const Vec3d& a, const Vec3d& b) {
        return glm::dot(normal_, glm::cross(a, b)) > k_least_sine * glm::length(a) * glm::length(b);
    };
    for (std::size_t i = 0; i < n; ++i)
        if (!turns(corner_[(i + 1) % n] - corner_[i], corner_[(i + 2) % n] - corner_[(i + 1) % n])) return false;
    for (std::size_t i = 1; i + 1 < n; ++i)
        if (!turns(corner_[i] - corner_[0], corner_[i + 1] - corner_[0])) return false;
    return n >= 3;
}

double ConvexFace::distance(const Vec3d& p) const {
    bool over = true;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < corner_.size(); ++i) {
        const Vec3d &a = corner_[i], &b = corner_[(i + 1) % corner_.size()];
        if (glm::dot(glm::cross(normal_, b - a), p - a) >= 0) continue;
        over = false;
        nearest = std::min(nearest, segment_distance(p, a, b));
    }
    return over ? std::abs(glm::dot(normal_, p - corner_[0])) : nearest;
}

double ConvexFace::side_distance(const Vec3d& p, std::size_t i) const {
    return segment_distance(p, corner_[i], corner_[(i + 1) % corner_.size()]);
}

double ConvexFace::side_distance_in_plane(const Vec3d& p, std::size_t i) const {
    return side_distance(p - glm::dot(normal_, p - corner_[0]) * normal_, i);
}

}  // namespace tetrakis::detail
