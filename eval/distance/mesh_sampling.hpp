#pragma once

#include "../../hier/base/vec.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tetrakis::detail {

/// Sample k of m^2 inside a triangle, as weights (u, v) of its second and third corner. The triangle is cut into m^2
/// equal ones with one sample each. For m = 1 it is the centroid; else the R2 sequence (M. Roberts 2018, generalised
/// golden ratio) places it, so that regular patterns cannot hide between samples. Consecutive samples are in
/// neighbouring parts.
inline Vec2d inside_sample(std::uint64_t k, std::uint32_t m) {
    // Rows are counted from the last one, the single triangle at the third corner, which closes the square m^2.
    const std::uint64_t left = std::uint64_t{m} * m - k;
    auto rows_left = static_cast<std::uint64_t>(std::sqrt(static_cast<double>(left)));
    while (rows_left * rows_left < left) ++rows_left;
    while (rows_left > 1 && (rows_left - 1) * (rows_left - 1) >= left) --rows_left;
    const std::uint64_t row = m - rows_left;
    std::uint64_t column = rows_left * rows_left - left;
    if (row % 2 == 1) column = 2 * rows_left - 2 - column;  // odd rows run backwards
    // 1/g and 1/g^2 of g^3 = g + 1.
    constexpr double k_step_u = 0.75487766624669276005, k_step_v = 0.56984029099805326591;
    Vec2d at(1.0 / 3, 1.0 / 3);
    if (m > 1) {
        at = Vec2d(glm::fract(at.x + static_cast<double>(k) * k_step_u),
                   glm::fract(at.y + static_cast<double>(k) * k_step_v));
        if (at.x + at.y > 1) at = Vec2d(1) - at;
    }
    const Vec2d cell(static_cast<double>(column / 2), static_cast<double>(row));
    return (column % 2 == 0 ? cell + at : cell + Vec2d(1) - at) / static_cast<double>(m);
}

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
