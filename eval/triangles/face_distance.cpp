#include "face_distance.hpp"

#include "../../hier/base/nearest_point.hpp"
#include "avx2.hpp"

#include <cstring>
#include <limits>
#include <utility>

namespace tetrakis::detail {

void FaceDistance::set(const std::array<Vec3d, 3>& triangle, const EdgeSliding& sliding) {
    set(std::span<const Vec3d>(triangle));
    for (std::size_t k = 0; k < 3 && !sliver_; ++k)
        if (sliding.edge[k]) set_sliding(k, sliding.fold[k], sliding.flap[k], normal_);
}

void FaceDistance::set(std::span<const Vec3d> corners) {
    const std::size_t n = corners.size();
    corner_.assign(corners.begin(), corners.end());
    edge_.assign(n, {});
    height_ = fold_ = 0;
    stretch_ = 1;
    convex_ = sliver_ = has_squares_ = false;
    if (n == 3) {
        const Vec3d u = corners[1] - corners[0], v = corners[2] - corners[0], cross = glm::cross(u, v);
        normal_ = unit_or_zero(cross);
        convex_ = normal_ != Vec3d(0);
        // Bound on sin^2 of the angle at corner 0: below it, the normal of the triangle is not used.
        constexpr double k_thin = 1e-4;
        sliver_ = !(glm::dot(cross, cross) > k_thin * (glm::dot(u, u) * glm::dot(v, v)));
        if (sliver_) return;
    } else {
        Vec3d middle(0), area(0);
        for (const Vec3d& p : corners) middle += p / static_cast<double>(n);
        for (std::size_t i = 0; i < n; ++i) area += glm::cross(corners[i] - middle, corners[(i + 1) % n] - middle);
        normal_ = unit_or_zero(area);
        for (Vec3d& p : corner_) {
            const double height = glm::dot(normal_, p - middle);
            height_ = std::max(height_, std::abs(height));
            p -= height * normal_;
        }
    }
    x_ = unit_or_zero(corner_[1] - corner_[0]);
    y_ = glm::cross(normal_, x_);
    for (std::size_t i = 0; i < n; ++i) edge_[i].start = Vec2d(local(corner_[i]));
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2d side = edge_[(i + 1) % n].start - edge_[i].start;
        edge_[i].length = glm::length(side);
        if (edge_[i].length > 0) edge_[i].along = side / edge_[i].length;
    }
    if (n > 3) convex_ = turns_once();
    has_squares_ = n == 3;
}

bool FaceDistance::turns_once() const {
    // Left turns at all corners, and as seen from the first corner: so the polygon goes around only once.
    constexpr double k_least_sine = 1e-9;
    const std::size_t n = edge_.size();
    const auto turns = [&](const Vec2d& a, const Vec2d& b) {
        return a.x * b.y - a.y * b.x > k_least_sine * glm::length(a) * glm::length(b);
    };
    for (std::size_t i = 0; i < n; ++i)
        if (!turns(edge_[i].along, edge_[(i + 1) % n].along)) return false;
    for (std::size_t i = 1; i + 1 < n; ++i)
        if (!turns(edge_[i].start, edge_[i + 1].start)) return false;
    return true;
}

void FaceDistance::set_sliding(std::size_t k, double fold, double flap, const Vec3d& normal) {
    // Angle between the planes of the face and of its triangle: for sines up to 0.5 it is below 1.05 times the sine.
    const double sine = glm::length(glm::cross(normal, normal_));
    if (sine > 0.5 || !(glm::dot(normal, normal_) > 0)) return;
    Edge& edge = edge_[k];
    edge.slides = true;
    has_squares_ = false;
    edge.fold = fold + 1.05 * sine;
    edge.flap = std::min(flap, 1.0);
    // With base angles of at most half the exterior angle a at both ends, the face and its flaps are convex. The
    // tangent of a / 2 is sin a / (1 + cos a).
    const std::size_t n = edge_.size();
    for (const auto& [before, after] : {std::pair{(k + n - 1) % n, k}, {k, (k + 1) % n}}) {
        const Vec2d &a = edge_[before].along, &b = edge_[after].along;
        edge.flap = std::min(edge.flap, 0.999 * (a.x * b.y - a.y * b.x) / (1 + glm::dot(a, b)));
    }
    fold_ = std::max(fold_, edge.fold);
    stretch_ = (1 + fold_) * (1 + 0.25 * fold_ * fold_);
}

double FaceDistance::to_face(const Vec3d& local) const {
    if (sliver_)
        return std::sqrt(nearest_on_triangle(corner_[0] + local, corner_[0], corner_[1], corner_[2]).squared_distance);
    const double high = std::abs(local.z);
    double squared = std::numeric_limits<double>::infinity();
    int over = 0;
    for (const Edge& edge : edge_) {
        const double off = edge.outside(local);
        if (off <= 0) continue;
        squared = std::min(squared, edge.squared_distance(local, off));
        ++over;
    }
    if (over == 0) return high / stretch_;
    if (over == 1 && fold_ > 0)
        for (const Edge& edge : edge_)
            if (const double off = edge.outside(local); off > 0 && edge.slides && edge.in_flaps(local, off))
                return (high + edge.fold * off) / stretch_;
    return (std::sqrt(high * high + squared) + fold_ * std::sqrt(squared)) / stretch_;
}

double FaceDistance::to_edge(const Vec3d& local, std::size_t k) const {
    if (sliver_) return segment_distance(corner_[0] + local, corner_[k], corner_[(k + 1) % 3]);
    const Edge& edge = edge_[k];
    const double off = std::abs(edge.outside(local));
    const double distance = std::sqrt(local.z * local.z + edge.squared_distance(local, off));
    if (!edge.slides) return distance;
    const double error = edge.in_flaps(local, off) ? std::abs(local.z) + fold_ * off : distance * (1 + fold_);
    return error * (1 + 0.25 * fold_ * fold_) / stretch_;
}

TETRAKIS_FOR_AVX2_TOO
void FaceDistance::squares(const std::array<const double*, 3>& points, std::size_t count, Squares& out) const {
    using Lanes [[gnu::vector_size(4 * sizeof(double))]] = double;
    const Lanes zero{};
    for (std::size_t i = 0; i + 4 <= count; i += 4) {
        const auto project = [&](const Vec3d& axis, Lanes& sum) {
            for (std::size_t k = 0; k < 3; ++k) {
                Lanes p;
                std::memcpy(&p, points[k] + i, sizeof(p));
                sum += (&axis.x)[k] * (p - (&corner_[0].x)[k]);
            }
        };
        const auto store = [i](std::array<double, k_most_points>& to, const Lanes& value) {
            std::memcpy(&to[i], &value, sizeof(value));
        };
        Lanes x{}, y{}, high{};
        project(x_, x), project(y_, y), project(normal_, high);
        const Lanes squared_height = high * high;
        Lanes beside = zero + std::numeric_limits<double>::infinity(), outside = zero;
        for (std::size_t k = 0; k < 3; ++k) {
            const Edge& edge = edge_[k];
            const Lanes dx = x - edge.start.x, dy = y - edge.start.y;
            const Lanes off = dx * edge.along.y - dy * edge.along.x, at = dx * edge.along.x + dy * edge.along.y;
            const Lanes in = at > zero ? at : zero, length = zero + edge.length;
            const Lanes beyond = at - (in < length ? in : length), squared = off * off + beyond * beyond;
            store(out[k + 1], squared_height + squared);
            beside = ((off > zero) & (squared < beside)) ? squared : beside;
            outside = off > outside ? off : outside;
        }
        store(out[0], squared_height + (outside > zero ? beside : zero));
    }
}

}  // namespace tetrakis::detail
