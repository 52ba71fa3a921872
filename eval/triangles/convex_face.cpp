#include "convex_face.hpp"

#include "point_triangle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrakis::detail {

ConvexFace::ConvexFace(std::span<const Vec3d> corners) : corner_(corners.begin(), corners.end()) {
    const std::size_t n = corners.size();
    Vec3d middle(0), area(0);
    for (const Vec3d& p : corners) middle += p / static_cast<double>(n);
    for (std::size_t i = 0; i < n; ++i) area += glm::cross(corners[i] - middle, corners[(i + 1) % n] - middle);
    normal_ = unit_or_zero(area);
    for (Vec3d& p : corner_) {
        const double height = glm::dot(normal_, p - middle);
        height_ = std::max(height_, std::abs(height));
        p -= height * normal_;
    }
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3d side = corner_[(i + 1) % n] - corner_[i];
        const Vec3d along = unit_or_zero(side);
        edge_.push_back({along, glm::cross(along, normal_), glm::length(side)});
    }
    convex_ = turns_once();
}

bool ConvexFace::turns_once() const {
    // Left turns at all corners, and as seen from the first corner: so the polygon goes around only once.
    constexpr double k_least_sine = 1e-9;
    const std::size_t n = corner_.size();
    const auto turns = [&](const Vec3d& a, const Vec3d& b) {
        return glm::dot(normal_, glm::cross(a, b)) > k_least_sine * glm::length(a) * glm::length(b);
    };
    for (std::size_t i = 0; i < n; ++i)
        if (!turns(edge_[i].along, edge_[(i + 1) % n].along)) return false;
    for (std::size_t i = 1; i + 1 < n; ++i)
        if (!turns(corner_[i] - corner_[0], corner_[i + 1] - corner_[0])) return false;
    return n >= 3;
}

void ConvexFace::set_sliding(std::size_t k, double fold, double flap, const Vec3d& normal) {
    // Angle between the planes of the face and of its triangle: for sines up to 0.5 it is below 1.05 times the sine.
    const double sine = glm::length(glm::cross(normal, normal_));
    if (sine > 0.5 || !(glm::dot(normal, normal_) > 0)) return;
    Edge& edge = edge_[k];
    edge.slides = true;
    edge.fold = fold + 1.05 * sine;
    edge.flap = std::min(flap, 1.0);
    // With base angles of at most half the exterior angle a at both ends, the face and its flaps are convex. The
    // tangent of a / 2 is sin a / (1 + cos a).
    const std::size_t n = edge_.size();
    for (const auto& [before, after] : {std::pair{(k + n - 1) % n, k}, {k, (k + 1) % n}}) {
        const Vec3d &a = edge_[before].along, &b = edge_[after].along;
        edge.flap = std::min(edge.flap, 0.999 * glm::dot(normal_, glm::cross(a, b)) / (1 + glm::dot(a, b)));
    }
    fold_ = std::max(fold_, edge.fold);
}

double ConvexFace::edge_distance(const Vec3d& p, std::size_t k) const {
    return segment_distance(p, corner_[k], corner_[(k + 1) % corner_.size()]);
}

bool ConvexFace::in_flaps(const Vec3d& p, std::size_t k, double off) const {
    const double along = glm::dot(p - corner_[k], edge_[k].along);
    return off <= edge_[k].flap * std::min(along, edge_[k].length - along);
}

double ConvexFace::to_face(const Vec3d& p) const {
    const double height = std::abs(glm::dot(normal_, p - corner_[0]));
    std::size_t over = 0, count = 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < edge_.size(); ++k)
        if (glm::dot(p - corner_[k], edge_[k].out) > 0) {
            nearest = std::min(nearest, edge_distance(p, k));
            over = k;
            ++count;
        }
    if (count == 0) return height / stretch();
    const double out = glm::dot(p - corner_[over], edge_[over].out);
    if (count == 1 && edge_[over].slides && in_flaps(p, over, out))
        return (height + edge_[over].fold * out) / stretch();
    const double off = std::sqrt(std::max(0.0, nearest * nearest - height * height));
    return (nearest + fold_ * off) / stretch();
}

double ConvexFace::to_edge(const Vec3d& p, std::size_t k) const {
    if (!edge_[k].slides) return edge_distance(p, k);
    const double off = std::abs(glm::dot(p - corner_[k], edge_[k].out));
    const double height = std::abs(glm::dot(normal_, p - corner_[0]));
    const double error = in_flaps(p, k, off) ? height + fold_ * off : (1 + fold_) * edge_distance(p, k);
    return error * (1 + 0.25 * fold_ * fold_) / stretch();
}

}  // namespace tetrakis::detail
