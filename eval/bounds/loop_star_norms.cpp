#include "../loop_patches/loop_cell.hpp"
#include "bezier_pieces.hpp"
#include "star_norms.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>

namespace tetrakis::detail {

namespace {

constexpr int k_most_loop_valence = 32;
/// Steps to the innermost star, and how often the regular triangles of the first one are bisected; less in each
/// further.
constexpr int k_loop_steps = 10, k_bisections = 4;

/// A part of a star's cell: the parameters of its corners, those of the cell being (0, 0), (1, 0) and (0, 1).
using Corners = std::array<Vec2d, 3>;

template <class Take>
void take_patch(const BezierTriangle<4>& patch, const Corners& at, int bisections, const Take& take) {
    if (bisections > 0) {
        const auto [first, second] = patch.halves();
        const Vec2d middle = 0.5 * (at[0] + at[1]);
        take_patch(first, {at[2], at[0], middle}, bisections - 1, take);
        take_patch(second, {at[1], at[2], middle}, bisections - 1, take);
        return;
    }
    for (int j = 0; j <= 4; ++j)
        for (int i = 0; i + j <= 4; ++i)
            take(patch.point[BezierTriangle<4>::index(i, j)],
                 0.25 * ((4.0 - i - j) * at[0] + double(i) * at[1] + double(j) * at[2]));
}

/// Calls take(p, parameters) with points such that the hull of the p less any linear function of the parameters holds
/// the surface of a star less that function.
template <class Take>
void take_star(int valence, std::span<const Vec3d> points, const Take& take) {
    std::vector<Vec3d> star(points.begin(), points.end()), step(static_cast<std::size_t>(loop_star_step_size(valence)));
    const double beta = loop_vertex_rule(valence).beta;
    double half = 0.5;
    for (int i = 0; i < k_loop_steps; ++i, half *= 0.5) {
        loop_star_step(valence, beta, star.data(), step.data());
        const Vec2d m01(half, 0), m02(0, half), m12(half), c1(2 * half, 0), c2(0, 2 * half);
        const std::array<Corners, 3> at = {{{m01, c1, m12}, {m02, m12, c2}, {m12, m02, m01}}};
        for (int quarter = 1; quarter <= 3; ++quarter)
            take_patch(box_spline_triangle(loop_star_quarter(valence, step.data(), quarter)),
                       at[static_cast<std::size_t>(quarter - 1)], std::max(k_bisections - 2 * i, 0), take);
        std::copy_n(step.begin(), star.size(), star.begin());
    }
    for (const Vec3d& p : star)
        for (const Vec2d& corner : {Vec2d(0), Vec2d(2 * half, 0), Vec2d(0, 2 * half)}) take(p, corner);
}

/// A flat star with equal angles at the extraordinary vertex.
std::vector<Vec2d> reference_loop_star(int valence) {
    std::vector<Vec2d> points = {Vec2d(0)};
    for (int i = 0; i < valence; ++i) {
        const double angle = 2 * std::numbers::pi * i / valence;
        points.emplace_back(std::cos(angle), std::sin(angle));
    }
    const Vec2d a = points[1], b = points[2], before = points[static_cast<std::size_t>(valence)], after = points[3];
    for (const Vec2d& p : {a + before, 2.0 * a, a + b, 2.0 * b, b + after}) points.push_back(p);
    return points;
}

std::unique_ptr<const StarNorms> norms_of(int valence) {
    return std::make_unique<const StarNorms>(
        reference_loop_star(valence), 1, [&](std::span<const Vec3d> points, const auto& take) {
            const Vec3d origin = loop_star_limit(valence, points.data()),
                        by_x = loop_star_corner(valence, points.data(), 1) - origin,
                        by_y = loop_star_corner(valence, points.data(), 2) - origin;
            take_star(valence, points,
                      [&](const Vec3d& p, const Vec2d& at) { take(0, p - (origin + at.x * by_x + at.y * by_y)); });
        });
}

}  // namespace

const StarNorms* StarNorms::loop(int valence) {
    if (valence < 3 || valence > k_most_loop_valence) return nullptr;
    static std::array<std::atomic<const StarNorms*>, k_most_loop_valence + 1> known{};
    return find_or_make(known[static_cast<std::size_t>(valence)], [&] { return norms_of(valence); });
}

}  // namespace tetrakis::detail
