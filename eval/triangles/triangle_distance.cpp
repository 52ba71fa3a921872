#include "triangle_distance.hpp"

#include "point_triangle.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

TriangleDistance::TriangleDistance(const std::array<Vec3d, 3>& corners, const EdgeSliding& sliding)
    : corners_(corners) {
    const Vec3d u = corners[1] - corners[0], v = corners[2] - corners[0], w = corners[2] - corners[1];
    const Vec3d n = glm::cross(u, v);
    const double squared = glm::dot(n, n), uu = glm::dot(u, u), vv = glm::dot(v, v), ww = glm::dot(w, w);
    // Bound on sin^2 of the angle at corner 0: below it, the normal of the triangle is not used.
    constexpr double k_thin = 1e-4;
    sliver_ = !(squared > k_thin * (uu * vv));
    if (sliver_) return;
    to_b1_ = glm::cross(v, n) / squared;
    to_b2_ = glm::cross(n, u) / squared;
    const double area = std::sqrt(squared);
    normal_ = n / area;
    height_ = {area / std::sqrt(uu), area / std::sqrt(ww), area / std::sqrt(vv)};
    foot_ = {glm::dot(u, v) / uu, -glm::dot(u, w) / ww, glm::dot(v, w) / vv};
    slides_ = sliding.any();
    if (!slides_) return;
    sliding_ = sliding;
    fold_ = std::max({sliding.fold[0], sliding.fold[1], sliding.fold[2]});
    length_ = {std::sqrt(uu), std::sqrt(ww), std::sqrt(vv)};
    stretch_ = (1 + fold_) * (1 + 0.25 * fold_ * fold_);
}

double TriangleDistance::sliding(const Vec3d& local) const {
    const double high = std::abs(local.z);
    std::size_t over = 3;
    bool corner = false;
    for (std::size_t k = 0; k < 3; ++k)
        if (opposite(local, k) < 0) {
            corner |= over != 3;
            over = k;
        }
    if (over == 3) return high / stretch_;
    if (!corner && sliding_.edge[over]) {
        const double out = -opposite(local, over) * height_[over];
        if (in_flaps(local, over, out)) return (high + sliding_.fold[over] * out) / stretch_;
    }
    const double off = std::sqrt(squared_beside(local));
    return (std::sqrt(high * high + off * off) + fold_ * off) / stretch_;
}

double TriangleDistance::sliding_over(const Vec3d& local, std::size_t k) const {
    const double off = std::abs(opposite(local, k)) * height_[k];
    const double error =
        in_flaps(local, k, off) ? std::abs(local.z) + fold_ * off : std::sqrt(squared_to_edge(local, k)) * (1 + fold_);
    return error * (1 + 0.25 * fold_ * fold_) / stretch_;
}

Vec3d TriangleDistance::position(const Vec3d& local) const {
    if (sliver_) return corners_[0] + local;
    return corners_[0] + local.x * (corners_[1] - corners_[0]) + local.y * (corners_[2] - corners_[0]) +
           local.z * normal_;
}

double TriangleDistance::squared_beside(const Vec3d& local) const {
    // If the foot lies outside an edge and between the edge's ends, that edge is the nearest.
    if (!sliver_)
        for (std::size_t k = 0; k < 3; ++k) {
            const double over = opposite(local, k);
            if (over >= 0) continue;
            const double along = place(local, k);
            if (along < 0 || along > 1) continue;
            return over * height_[k] * (over * height_[k]);
        }
    const double squared = nearest_on_triangle(position(local), corners_[0], corners_[1], corners_[2]).squared_distance;
    return sliver_ ? squared : std::max(0.0, squared - local.z * local.z);
}

double TriangleDistance::squared_beyond_edge(const Vec3d& local, std::size_t k) const {
    const double distance = segment_distance(position(local), corners_[k], corners_[(k + 1) % 3]);
    return distance * distance;
}

}  // namespace tetrakis::detail
