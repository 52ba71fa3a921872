#pragma once

#include "tetrakis/hier/vec.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

/// Nearest point of a set, by a sweep over x: for comparing meshes whose vertices are numbered differently.
class PointMatch {
  public:
    explicit PointMatch(std::span<const tetrakis::Vec3d> points) : points_(points), order_(points.size()) {
        std::iota(order_.begin(), order_.end(), 0u);
        // Any direction serves; a skew one keeps symmetric models from having many points at the same place on it.
        std::sort(order_.begin(), order_.end(), [&](auto a, auto b) { return key(points[a]) < key(points[b]); });
    }

    std::uint32_t nearest(const tetrakis::Vec3d& p) const {
        const double k = key(p);
        const auto middle = std::lower_bound(order_.begin(), order_.end(), k,
                                             [&](std::uint32_t i, double value) { return key(points_[i]) < value; });
        double best = std::numeric_limits<double>::infinity();
        std::uint32_t found = 0;
        const auto look = [&](std::uint32_t i) {
            const double d = glm::length(points_[i] - p);
            if (d < best || (d == best && i < found)) {
                best = d;
                found = i;
            }
            return std::abs(key(points_[i]) - k) <= best;  // the key's gradient has unit length
        };
        for (auto it = middle; it != order_.end() && look(*it); ++it) {
        }
        for (auto it = middle; it != order_.begin() && look(*--it);) {
        }
        return found;
    }

  private:
    static double key(const tetrakis::Vec3d& p) { return 0.8 * p.x + 0.36 * p.y + 0.48 * p.z; }
    std::span<const tetrakis::Vec3d> points_;
    std::vector<std::uint32_t> order_;
};
