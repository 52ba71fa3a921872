#include "star_norms.hpp"

#include "../patches/star.hpp"

#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr int k_most_valence = 32;
constexpr double k_rounding_of_sums = 1 + 1e-12;  // of some dozens of points
/// Steps to the innermost star.
constexpr int k_steps = 10;
/// How often regular cells of the first step are cut up, and triangles bisected; less in each further step.
constexpr int k_cuts = 2, k_bisections = 4;

Vec2d polar(double radius, double angle) { return radius * Vec2d(std::cos(angle), std::sin(angle)); }

/// A part of a quad star's cell in the cell's parameters: of a side's length, less than 0 where it is turned by half.
struct Square {
    Vec2d origin{0.0};
    double side = 1;

    Vec2d operator()(double x, double y) const { return origin + side * Vec2d(x, y); }
    Square quarter(double x, double y) const { return {(*this)(0.5 * x, 0.5 * y), 0.5 * side}; }
};

/// Bezier control points of a cell, and their parameters.
template <class Take>
void take_bezier(const Net16& net, const Square& square, const Take& take) {
    const auto along = [](const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
        return std::array<Vec3d, 4>{(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0,
                                    (b + 4.0 * c + d) / 6.0};
    };
    std::array<std::array<Vec3d, 4>, 4> rows;
    for (int y = 0; y < 4; ++y)
        rows[static_cast<std::size_t>(y)] =
            along(net.at(-1, y - 1), net.at(0, y - 1), net.at(1, y - 1), net.at(2, y - 1));
    for (std::size_t x = 0; x < 4; ++x) {
        const auto column = along(rows[0][x], rows[1][x], rows[2][x], rows[3][x]);
        for (std::size_t y = 0; y < 4; ++y)
            take(column[y], square(static_cast<double>(x) / 3, static_cast<double>(y) / 3));
    }
}

template <class Take>
void take_net(const Net16& net, const Square& square, int cuts, const Take& take) {
    if (cuts <= 0) return take_bezier(net, square, take);
    for (int k = 0; k < 4; ++k) {
        Net16 child;
        child_net(net, k & 1, k >> 1, child);
        take_net(child, square.quarter(k & 1, k >> 1), cuts - 1, take);
    }
}

/// Calls take(p, parameters) with points such that the hull of the p less any bilinear function of the parameters holds
/// the surface of a star less that function.
template <class Take>
void take_star(const QuadStar& star, const Square& square, int step, const Take& take) {
    constexpr std::array<std::array<double, 2>, 4> k_corner = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    if (step == k_steps) {
        for (const Vec3d& p : star.points)
            for (const auto& [x, y] : k_corner) take(p, square(x, y));
        return;
    }
    std::array<QuadStar, 4> quarters;
    subdivide(star, quarters);
    for (std::size_t k = 0; k < 4; ++k) {
        const Square quarter = square.quarter(k_corner[k][0], k_corner[k][1]);
        if (quarters[k].regular())
            take_net(quarters[k].net(static_cast<int>(k)), quarter, k_cuts - step, take);
        else
            take_star(quarters[k], k == 2 ? Square{square(1, 1), -quarter.side} : quarter, step + 1, take);
    }
}

/// A flat star whose faces around each of the two corners are alike.
std::vector<Vec2d> reference_star(int valence, int far_valence) {
    const double at_near = std::numbers::pi / valence, at_far = std::numbers::pi / far_valence;
    // A kite with unit sides at the near corner.
    const double half_width = std::sin(at_near), side = half_width / std::sin(at_far),
                 length = std::cos(at_near) + half_width / std::tan(at_far);
    std::vector<Vec2d> points = {Vec2d(0)};
    for (int i = 0; i < valence; ++i) {
        points.push_back(polar(1, 2 * i * at_near));
        points.push_back(polar(length, (2 * i + 1) * at_near));
    }
    const Vec2d far = polar(length, at_near);
    // Step j around the far corner, edges where it is odd.
    const auto around_far = [&](int j) {
        return far + polar(j % 2 == 0 ? length : side, std::numbers::pi + at_near + j * at_far);
    };
    const auto mirrored = [](const Vec2d& p, double axis) {
        const double c = std::cos(2 * axis), s = std::sin(2 * axis);
        return Vec2d(c * p.x + s * p.y, s * p.x - c * p.y);
    };
    points.push_back(mirrored(around_far(3), 0));
    for (int j = 2; j <= 2 * far_valence - 2; ++j) points.push_back(around_far(j));
    points.push_back(mirrored(around_far(-3), 2 * at_near));
    return points;
}

/// A part of a triangle star's cell: the parameters of its corners.
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
            take(patch(i, j), 0.25 * ((4.0 - i - j) * at[0] + double(i) * at[1] + double(j) * at[2]));
}

/// The same of Loop, for linear functions.
template <class Take>
void take_star(LoopStar star, const Take& take) {
    double half = 0.5;
    for (int i = 0; i < k_steps; ++i, half *= 0.5) {
        std::array<LoopStar, 4> quarters;
        subdivide(star, quarters);
        const Vec2d m01(half, 0), m02(0, half), m12(half), c1(2 * half, 0), c2(0, 2 * half);
        const std::array<Corners, 4> at = {{{}, {c1, m12, m01}, {c2, m02, m12}, {m12, m02, m01}}};
        for (std::size_t k = 1; k < 4; ++k)
            take_patch(box_spline_triangle(quarters[k].net(0)), at[k], std::max(k_bisections - 2 * i, 0), take);
        star = std::move(quarters[0]);
    }
    for (const Vec3d& p : star.points)
        for (const Vec2d& corner : {Vec2d(0), Vec2d(2 * half, 0), Vec2d(0, 2 * half)}) take(p, corner);
}

/// A flat star with equal angles at the extraordinary vertex.
std::vector<Vec2d> reference_star(int valence) {
    std::vector<Vec2d> points = {Vec2d(0)};
    for (int i = 0; i < valence; ++i) points.push_back(polar(1, 2 * std::numbers::pi * i / valence));
    const Vec2d a = points[1], b = points[2], before = points[static_cast<std::size_t>(valence)], after = points[3];
    for (const Vec2d& p : {a + before, 2.0 * a, a + b, 2.0 * b, b + after}) points.push_back(p);
    return points;
}

bool has_norms(int valence) { return valence >= 3 && valence <= k_most_valence; }

}  // namespace

/// Of one pair of valences, found at the first call, from any thread.
struct StarNorms::Slot {
    std::once_flag once;
    std::unique_ptr<const StarNorms> norms;

    template <class Make>
    const StarNorms* get(const Make& make) {
        std::call_once(once, [&] { norms = make(); });
        return norms.get();
    }
};

template <class Deviations>
std::unique_ptr<const StarNorms> StarNorms::make(std::vector<Vec2d> reference, const Deviations& deviations) {
    std::unique_ptr<StarNorms> result(new StarNorms);
    const std::size_t count = reference.size();
    const auto note = [](double& most, double size) { most = std::max(most, size * k_rounding_of_sums); };
    std::vector<Vec3d> points(count);
    result->norm_.assign(count, 0);
    // The weights of three points at a time.
    for (std::size_t first = 0; first < count; first += 3) {
        for (std::size_t i = 0; i < count; ++i) points[i] = Vec3d(i == first, i == first + 1, i == first + 2);
        deviations(points, [&](const Vec3d& d) {
            for (std::size_t k = 0; k < 3 && first + k < count; ++k)
                note(result->norm_[first + k], std::abs(d[static_cast<int>(k)]));
        });
    }
    for (std::size_t i = 0; i < count; ++i) points[i] = Vec3d(reference[i], 0);
    deviations(points, [&](const Vec3d& d) { note(result->reference_deviation_, glm::length(d)); });
    result->reference_ = std::move(reference);
    result->find_fit();
    return result;
}

/// Least squares.
void StarNorms::find_fit() {
    glm::dmat3 normal(0);
    for (const Vec2d& p : reference_) normal += glm::outerProduct(Vec3d(1, p.x, p.y), Vec3d(1, p.x, p.y));
    for (const Vec2d& p : reference_) fit_.push_back(glm::inverse(normal) * Vec3d(1, p.x, p.y));
}

const StarNorms* StarNorms::catmull_clark(int valence, int far_valence) {
    if (!has_norms(valence) || !has_norms(far_valence)) return nullptr;
    static std::array<std::array<Slot, k_most_valence + 1>, k_most_valence + 1> known;
    return known[static_cast<std::size_t>(valence)][static_cast<std::size_t>(far_valence)].get([&] {
        return make(reference_star(valence, far_valence), [&](std::span<const Vec3d> points, const auto& take) {
            QuadStar star;
            star.resize(valence, far_valence);
            std::copy(points.begin(), points.end(), star.points.data());
            star.find_limit();
            const Vec3d c0 = star.corner_limit(0), by_x = star.corner_limit(1) - c0, by_y = star.corner_limit(3) - c0,
                        twist = star.corner_limit(2) - c0 - by_x - by_y;
            take_star(star, {}, 0, [&](const Vec3d& p, const Vec2d& at) {
                take(p - (c0 + at.x * by_x + at.y * by_y + at.x * at.y * twist));
            });
        });
    });
}

const StarNorms* StarNorms::loop(int valence) {
    if (!has_norms(valence)) return nullptr;
    static std::array<Slot, k_most_valence + 1> known;
    return known[static_cast<std::size_t>(valence)].get([&] {
        return make(reference_star(valence), [&](std::span<const Vec3d> points, const auto& take) {
            LoopStar star;
            star.resize({valence, 6, 6});
            std::copy(points.begin(), points.end(), star.points.data());
            const Vec3d origin = star.corner_limit(0), by_x = star.corner_limit(1) - origin,
                        by_y = star.corner_limit(2) - origin;
            take_star(std::move(star),
                      [&](const Vec3d& p, const Vec2d& at) { take(p - (origin + at.x * by_x + at.y * by_y)); });
        });
    });
}

double StarNorms::deviation(std::span<const Vec3d> points) const {
    Vec3d at(0), x(0), y(0);
    for (std::size_t i = 0; i < fit_.size(); ++i) {
        at += fit_[i].x * points[i];
        x += fit_[i].y * points[i];
        y += fit_[i].z * points[i];
    }
    // The affine map stretches by the larger singular value of its matrix at most.
    const double xx = glm::dot(x, x), yy = glm::dot(y, y), xy = glm::dot(x, y);
    const double stretch = std::sqrt(0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy));
    double sum = stretch * reference_deviation_;
    for (std::size_t i = 0; i < fit_.size(); ++i)
        sum += norm_[i] * glm::length(points[i] - (at + reference_[i].x * x + reference_[i].y * y));
    return sum * k_rounding_of_sums;
}

}  // namespace tetrakis::detail
