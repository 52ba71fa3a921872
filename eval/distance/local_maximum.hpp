#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>

namespace tetrakis::detail {

/// A point (u, v) of the triangle u, v >= 0, u + v <= 1, and the value of some function there.
struct Maximum {
    Vec2d at{0.0};
    double value = 0;
    void offer(const Vec2d& point, double there) {
        if (there > value) *this = {point, there};
    }
};

/// If the largest sample is above this share of the tolerance, a local maximum is searched near it.
inline constexpr double k_climb_from = 0.8;

/// Climbs from a sample of f to a local maximum nearby. A sweep takes the three directions of a lattice in turn, each
/// time to the top of the parabola through three points; the next sweep takes smaller steps.
/// @param from    the start, with the value of f there
/// @param step    about half the spacing of samples
/// @param sweeps  number of sweeps; each brings a smooth maximum much nearer
template <class F>
Maximum local_maximum(F&& f, Maximum from, double step, int sweeps = 2) {
    constexpr double k_finer = 0.25, k_farthest = 2;  // the next sweep's step; the farthest top, in steps
    constexpr Vec2d k_directions[3] = {{1, 0}, {0, 1}, {-1, 1}};
    const auto inside = [](const Vec2d& p) { return p.x >= 0 && p.y >= 0 && p.x + p.y <= 1; };
    for (int sweep = 0; sweep < sweeps; ++sweep, step *= k_finer)
        for (const Vec2d& direction : k_directions) {
            const Maximum middle = from;
            const Vec2d ahead = middle.at + step * direction, behind = middle.at - step * direction;
            if (!inside(ahead) || !inside(behind)) {
                for (const Vec2d& p : {ahead, behind})
                    if (inside(p)) from.offer(p, f(p));
                continue;
            }
            const double a = f(ahead), b = f(behind), bend = 2 * middle.value - a - b;
            from.offer(ahead, a), from.offer(behind, b);
            if (!(bend > 0)) continue;
            const Vec2d top = middle.at + std::clamp(0.5 * (a - b) / bend, -k_farthest, k_farthest) * step * direction;
            if (inside(top)) from.offer(top, f(top));
        }
    return from;
}

}  // namespace tetrakis::detail
