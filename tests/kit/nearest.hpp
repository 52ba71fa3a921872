#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis::test {

namespace detail {

inline Vec3d on_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b, int i, int j) {
    const Vec3d ab = b - a;
    const double length2 = glm::dot(ab, ab);
    const double t = length2 > 0 ? std::clamp(glm::dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
    Vec3d weights(0.0);
    weights[i] = 1 - t;
    weights[j] += t;
    return weights;
}

/// Barycentric weights of the point of triangle a, b, c that is nearest to p.
inline Vec3d nearest_weights(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    const Vec3d n = glm::cross(b - a, c - a);
    const double area2 = glm::dot(n, n);
    if (area2 > 0) {  // the foot of the perpendicular, where it lies inside
        const double u = glm::dot(glm::cross(c - b, p - b), n) / area2;
        const double v = glm::dot(glm::cross(a - c, p - c), n) / area2;
        if (u >= 0 && v >= 0 && u + v <= 1) return {u, v, 1 - u - v};
    }
    Vec3d best(0.0);
    double best_distance = std::numeric_limits<double>::infinity();
    for (const Vec3d& w : {on_segment(p, a, b, 0, 1), on_segment(p, b, c, 1, 2), on_segment(p, c, a, 2, 0)}) {
        const double distance = glm::length(w.x * a + w.y * b + w.z * c - p);
        if (distance < best_distance) {
            best_distance = distance;
            best = w;
        }
    }
    return best;
}

inline double distance_to(const Vec3d& p, const Box3d& box) {
    return glm::length(glm::max(glm::max(box.lower - p, p - box.upper), Vec3d(0)));
}

}  // namespace detail

/// Nearest points on triangles, by a tree of boxes, in doubles. It shares no code with the library's measurement, so
/// that an error of the measurement cannot hide one of the tessellation.
class NearestTriangle {
  public:
    static constexpr double k_infinity = std::numeric_limits<double>::infinity();
    struct Hit {
        std::uint32_t triangle = 0xFFFF'FFFFu;
        double distance = k_infinity;
        Vec3d weights{0.0};  ///< barycentric, of the nearest point
    };

    NearestTriangle(std::vector<Vec3d> points, std::vector<std::array<std::uint32_t, 3>> triangles)
        : points_(std::move(points)), triangles_(std::move(triangles)), order_(triangles_.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
        std::vector<Vec3d> centres;
        for (const auto& t : triangles_) centres.push_back((points_[t[0]] + points_[t[1]] + points_[t[2]]) / 3.0);
        nodes_.emplace_back();
        split(0, 0, static_cast<std::uint32_t>(order_.size()), centres);
    }

    /// Of equally near triangles, the one with the lowest number.
    Hit nearest(const Vec3d& p) const {
        Hit best;
        visit(p, best.distance, [&](const Hit& h) {
            if (std::pair(h.distance, h.triangle) < std::pair(best.distance, best.triangle)) best = h;
        });
        return best;
    }
    double distance(const Vec3d& p) const { return nearest(p).distance; }
    /// All triangles no farther than `radius`, nearest first, equally near ones by their number.
    std::vector<Hit> within(const Vec3d& p, double radius) const {
        std::vector<Hit> hits;
        visit(p, radius, [&](const Hit& h) {
            if (h.distance <= radius) hits.push_back(h);
        });
        std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
            return std::pair(a.distance, a.triangle) < std::pair(b.distance, b.triangle);
        });
        return hits;
    }
    const std::array<std::uint32_t, 3>& triangle(std::uint32_t t) const { return triangles_[t]; }

  private:
    struct Node {
        Box3d box;
        std::uint32_t first = 0, count = 0;  ///< a leaf's triangles; count 0: its children are first and first + 1
    };
    void split(std::uint32_t node, std::uint32_t first, std::uint32_t count, const std::vector<Vec3d>& centres) {
        Box3d box, middles;
        for (std::uint32_t i = first; i < first + count; ++i) {
            for (const std::uint32_t v : triangles_[order_[i]]) box.add(points_[v]);
            middles.add(centres[order_[i]]);
        }
        nodes_[node] = {box, first, count};
        if (count <= 4) return;
        const Vec3d size = middles.upper - middles.lower;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const std::uint32_t half = count / 2;
        std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                         [&](std::uint32_t a, std::uint32_t b) { return centres[a][axis] < centres[b][axis]; });
        const auto child = static_cast<std::uint32_t>(nodes_.size());
        nodes_[node].first = child;
        nodes_[node].count = 0;
        nodes_.resize(child + 2);
        split(child, first, half, centres);
        split(child + 1, first + half, count - half, centres);
    }
    Hit hit(std::uint32_t triangle, const Vec3d& p) const {
        const auto& [i, j, k] = triangles_[triangle];
        const Vec3d &a = points_[i], &b = points_[j], &c = points_[k];
        const Vec3d w = detail::nearest_weights(p, a, b, c);
        return {triangle, glm::length(w.x * a + w.y * b + w.z * c - p), w};
    }
    /// Calls take(hit) for triangles whose box is within `radius`, nearer boxes first. `take` may lower `radius`.
    template <class Take>
    void visit(const Vec3d& p, const double& radius, const Take& take) const {
        if (triangles_.empty()) return;
        std::vector<std::pair<double, std::uint32_t>> open = {{detail::distance_to(p, nodes_[0].box), 0}};
        while (!open.empty()) {
            const auto [least, number] = open.back();
            open.pop_back();
            if (least > radius) continue;
            const Node& node = nodes_[number];
            if (node.count == 0) {
                std::pair<double, std::uint32_t> near = {detail::distance_to(p, nodes_[node.first].box), node.first};
                std::pair<double, std::uint32_t> far = {detail::distance_to(p, nodes_[node.first + 1].box),
                                                        node.first + 1};
                if (far < near) std::swap(near, far);
                open.push_back(far);
                open.push_back(near);
                continue;
            }
            for (std::uint32_t i = node.first; i < node.first + node.count; ++i) take(hit(order_[i], p));
        }
    }

    std::vector<Vec3d> points_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};
}  // namespace tetrakis::test

/// Nearest point of a set, for comparing meshes whose vertices are numbered differently.
class PointMatch {
  public:
    explicit PointMatch(std::span<const tetrakis::Vec3d> points)
        : nearest_({points.begin(), points.end()}, each_alone(points.size())) {}
    std::uint32_t nearest(const tetrakis::Vec3d& p) const { return nearest_.nearest(p).triangle; }
    /// Number of points no farther than `radius`.
    std::size_t count_within(const tetrakis::Vec3d& p, double radius) const {
        return nearest_.within(p, radius).size();
    }

  private:
    static std::vector<std::array<std::uint32_t, 3>> each_alone(std::size_t count) {
        std::vector<std::array<std::uint32_t, 3>> triangles(count);
        for (std::uint32_t i = 0; i < count; ++i) triangles[i] = {i, i, i};
        return triangles;
    }
    tetrakis::test::NearestTriangle nearest_;
};
