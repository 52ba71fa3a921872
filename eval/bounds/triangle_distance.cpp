#include "triangle_distance.hpp"

#include "plane_measure.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

TriangleDistance::TriangleDistance(const std::array<Vec3d, 3>& corners) : corners_(corners) {
    const Vec3d u = corners[1] - corners[0], v = corners[2] - corners[0], w = corners[2] - corners[1];
    const Vec3d n = glm::cross(u, v);
    const double squared = glm::dot(n, n), uu = glm::dot(u, u), vv = glm::dot(v, v), ww = glm::dot(w, w);
    // sin^2 of the angle at corner 0: in thinner triangles the normal is left alone.
    constexpr double k_thin = 1e-4;
    sliver_ = !(squared > k_thin * (uu * vv));
    if (sliver_) return;
    to_b1_ = glm::cross(v, n) / squared;
    to_b2_ = glm::cross(n, u) / squared;
    const double area = std::sqrt(squared);
    normal_ = n / area;
    height_ = {area / std::sqrt(uu), area / std::sqrt(ww), area / std::sqrt(vv)};
    foot_ = {glm::dot(u, v) / uu, -glm::dot(u, w) / ww, glm::dot(v, w) / vv};
}

void TriangleDistance::set_slack(const EdgeSlack& slack) {
    has_slack_ = !sliver_ && slack.any();
    stretch_ = 1;
    if (!has_slack_) return;
    slack_ = slack;
    fold_ = std::max({slack.fold[0], slack.fold[1], slack.fold[2]});
    for (std::size_t k = 0; k < 3; ++k) length_[k] = glm::length(corners_[(k + 1) % 3] - corners_[k]);
    stretch_ = (1 + fold_) * (1 + 0.25 * fold_ * fold_);
}

/// Of any point whose height differs by at most `height`, and whose foot lies within `beside`.
double TriangleDistance::sliding(const Vec3d& local, double height, double beside) const {
    const double high = std::abs(local.z) + height;
    std::size_t over = 3;
    bool corner = false;
    for (std::size_t k = 0; k < 3; ++k)
        if (-opposite(local, k, 1) * height_[k] + beside > 0) {
            corner |= over != 3;
            over = k;
        }
    if (over == 3) return high / stretch_;
    if (!corner && slack_.fold[over] >= 0) {
        const double beyond = opposite(local, over, 1), place = forward(local, over, 1) + foot_[over] * beyond;
        const double out = beside - beyond * height_[over];
        if (out <= slack_.tent[over] * (std::min(place, 1 - place) * length_[over] - beside))
            return (high + slack_.fold[over] * out) / stretch_;
    }
    const double squared_beside = split(local).squared_beside;
    const double off = squared_beside == 0 ? std::max(0.0, beside - margin(local)) : std::sqrt(squared_beside) + beside;
    return (std::sqrt(high * high + off * off) + fold_ * off) / stretch_;
}

double TriangleDistance::sliding_over(const Vec3d& local, std::size_t k, double height, double whole) const {
    const double beyond = opposite(local, k, 1), place = forward(local, k, 1) + foot_[k] * beyond;
    const double off = std::abs(beyond) * height_[k] + whole;
    double error = 0;
    if (off <= slack_.tent[k] * (std::min(place, 1 - place) * length_[k] - whole)) {
        error = std::abs(local.z) + height + fold_ * off;
    } else {
        const double far = std::sqrt(squared_to_edge(local, k)) + whole;
        error = far + fold_ * far;
    }
    return error * (1 + 0.25 * fold_ * fold_) / stretch_;
}

Vec3d TriangleDistance::position(const Vec3d& local) const {
    if (sliver_) return corners_[0] + local;
    return corners_[0] + local.x * (corners_[1] - corners_[0]) + local.y * (corners_[2] - corners_[0]) +
           local.z * normal_;
}

TriangleDistance::Split TriangleDistance::split_beside(const Vec3d& local) const {
    const double height = sliver_ ? 0 : std::abs(local.z);
    // Where the foot lies over the middle of an edge and outside it alone, that edge is the nearest.
    if (!sliver_)
        for (std::size_t k = 0; k < 3; ++k) {
            const double over = opposite(local, k, 1);
            if (over >= 0) continue;
            const double place = forward(local, k, 1) + foot_[k] * over;
            if (place < 0 || place > 1) continue;
            const double beside = over * height_[k];
            return {height, beside * beside};
        }
    const double squared = nearest_on_triangle(position(local), corners_[0], corners_[1], corners_[2]).squared_distance;
    return {height, std::max(0.0, squared - height * height)};
}

double TriangleDistance::squared_beyond_edge(const Vec3d& local, std::size_t k) const {
    const double distance = segment_distance(position(local), corners_[k], corners_[(k + 1) % 3]);
    return distance * distance;
}

}  // namespace tetrakis::detail
