#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <vector>

namespace tetrakis::test {

/// The largest distance of a point to the nearest of the others; at most 1.
inline double farthest_from(const std::vector<Vec3d>& points, std::vector<Vec3d> others) {
    std::sort(others.begin(), others.end(), [](const Vec3d& a, const Vec3d& b) { return a.x < b.x; });
    double most = 0;
    for (const Vec3d& p : points) {
        constexpr double k_near = 1e-6;
        double best = 1;
        for (auto at = std::lower_bound(others.begin(), others.end(), p.x - k_near,
                                        [](const Vec3d&a, double x) { return a.x < x; });
             at != others.end() && at->x <= p.x + k_near; ++at)
            best = std::min(best, glm::length(*at - p));
        most = std::max(most, best);
    }
    return most;
}

}  // namespace tetrakis::test
