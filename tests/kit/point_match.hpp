#pragma once

#include "../../hier/base/vec.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// Nearest point of a set, by a sweep over one direction: for comparing meshes whose vertices are numbered differently.
class PointMatch {
  public:
    explicit PointMatch(std::span<const tetrakis::Vec3d> points) {
        entries_.reserve(points.size());
        for (const tetrakis::Vec3d& p : points)
            entries_.push_back({key(p), static_cast<std::uint32_t>(entries_.size()), p});
        std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.key < b.key; });
    }

    std::uint32_t nearest(const tetrakis::Vec3d& p) const {
        constexpr double k_infinity = std::numeric_limits<double>::infinity();
        const double k = key(p);
        auto above = std::lower_bound(entries_.begin(), entries_.end(), k,
                                      [](const Entry& e, double value) { return e.key < value; });
        auto below = above;
        double best = k_infinity;  // squared
        std::uint32_t found = 0;
        // The nearer side first: what is sought may be just below, and a walk upwards alone would see half of all.
        for (;;) {
            const double up = above != entries_.end() ? above->key - k : k_infinity;
            const double down = below != entries_.begin() ? k - (below - 1)->key : k_infinity;
            const double gap = std::min(up, down);
            if (!(gap < k_infinity && gap * gap <= best)) return found;  // the key's gradient has unit length
            const Entry& e = up <= down ? *above++ : *--below;
            const tetrakis::Vec3d to = e.point - p;
            const double d = to.x * to.x + to.y * to.y + to.z * to.z;
            if (d < best || (d == best && e.index < found)) {
                best = d;
                found = e.index;
            }
        }
    }

  private:
    struct Entry {
        double key;
        std::uint32_t index;
        tetrakis::Vec3d point;
    };
    // Any direction serves; a skew one keeps symmetric models from having many points at the same place on it.
    static double key(const tetrakis::Vec3d& p) { return 0.8 * p.x + 0.36 * p.y + 0.48 * p.z; }
    std::vector<Entry> entries_;  ///< by key
};

namespace tetrakis::test {

/// Largest distance of a point of one set from the other; both have as many.
inline double farthest_apart(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    REQUIRE(a.size() == b.size());
    const PointMatch in_a(a), in_b(b);
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max({worst, glm::length(a[i] - b[in_b.nearest(a[i])]), glm::length(b[i] - a[in_a.nearest(b[i])])});
    return worst;
}

}  // namespace tetrakis::test
