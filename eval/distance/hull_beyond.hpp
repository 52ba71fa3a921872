#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <limits>

namespace tetrakis::detail {

/// Whether the convex hull of some points is certainly farther from q than `reach`: a plane between them is looked for,
/// by a few steps towards the hull's nearest point (Frank, Wolfe 1956). False where it is not, or none is found.
/// @param at  Vec3d at(i), 0 <= i < count
template <class At>
bool hull_beyond(int count, At&& at, const Vec3d& q, double reach) {
    constexpr int k_steps = 6;
    Vec3d from_hull = q - at(0);
    for (int step = 0; step < k_steps; ++step) {
        const double square = glm::dot(from_hull, from_hull);
        if (!(square > reach * reach)) return false;
        double least = std::numeric_limits<double>::infinity();
        int which = 0;
        for (int i = 0; i < count; ++i) {
            const double along = glm::dot(q - at(i), from_hull);
            if (along < least) least = along, which = i;
        }
        if (least > 0 && least * least > reach * reach * square) return true;
        const Vec3d move = (q - at(which)) - from_hull;
        const double length = glm::dot(move, move), t = -glm::dot(from_hull, move);
        if (!(t > 0)) return false;
        from_hull += std::min(t / length, 1.0) * move;
    }
    return false;
}

}  // namespace tetrakis::detail
