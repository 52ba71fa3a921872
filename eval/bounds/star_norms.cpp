#include "star_norms.hpp"

#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <numbers>

namespace tetrakis::detail {

namespace {

constexpr int k_most_valence = 32;
constexpr double k_rounding_of_sums = 1 + 1e-12;  // of some dozens of points
/// Steps to the innermost star, and to the largest regular cells that are bounded without more steps.
constexpr int k_steps = 10, k_cuts = 3;

/// The parameters of a star's corners.
using Parameters = std::array<Vec2d, 4>;

/// Calls take(p, q) with control points p of a regular cell and their parameters q. For any bilinear function f, the
/// convex hull of all p - f(q) contains the surface minus f, because a cubic spline reproduces f.
template <class Take>
void take_regular(const QuadStar& star, const Parameters& at, const Take& take) {
    const Net16 net = net_of(star, 0);
    for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x)
            take(net.at(x, y), at[0] + double(x) * (at[1] - at[0]) + double(y) * (at[3] - at[0]));
}
/// The same on a triangle, for linear functions.
template <class Take>
void take_regular(const LoopStar& star, const Parameters& at, const Take& take) {
    const BezierTriangle<4> patch = box_spline_triangle(net_of(star, 0));
    for (int j = 0; j <= 4; ++j)
        for (int i = 0; i + j <= 4; ++i)
            take(patch(i, j), 0.25 * ((4.0 - i - j) * at[0] + double(i) * at[1] + double(j) * at[2]));
}
/// The same for a star, by its regular parts and the hulls of the innermost stars.
template <class Star, class Take>
void take_star(const Star& star, const Parameters& at, int step, const Take& take) {
    constexpr int n = Star::k_corners;
    if (star.regular() && step >= k_cuts) return take_regular(star, at, take);
    if (step == k_steps) {
        for (const Vec3d& p : star.points)
            for (int k = 0; k < n; ++k) take(p, at[k]);
        return;
    }
    std::array<Star, 4> quarters;
    subdivide(star, quarters);
    for (int k = 0; k < 4; ++k) {
        Parameters of_quarter;
        for (int c = 0; c < n; ++c)
            of_quarter[c] = 0.5 * (k < n ? at[k] + at[(k + c) % n] : at[(c + 1) % n] + at[(c + 2) % n]);
        take_star(quarters[k], of_quarter, step + 1, take);
    }
}

Vec2d polar(double radius, double angle) { return radius * Vec2d(std::cos(angle), std::sin(angle)); }

/// A flat star with equal angles at the extraordinary vertex; the outer faces continue the faces there.
template <int Corners>
std::vector<Vec2d> reference_star(int valence) {
    const double angle = 2 * std::numbers::pi / valence;
    std::vector<Vec2d> points = {Vec2d(0)};
    for (int i = 0; i < valence; ++i) {
        points.push_back(polar(1, i * angle));
        if (Corners == 4) points.push_back(polar(std::cos(angle / 2) + std::sin(angle / 2), (i + 0.5) * angle));
    }
    const auto add = [&](std::initializer_list<Vec2d> beyond) { points.insert(points.end(), beyond); };
    const Vec2d before = points.back(), a = points[1], b = points[2], c = points[3];
    if (Corners == 4)
        add({a + before, 2.0 * a, a + b, 2.0 * b, b + c, 2.0 * c, c + Vec2d(points[4])});
    else
        add({a + before, 2.0 * a, a + b, 2.0 * b, b + c});
    return points;
}

}  // namespace

template <int Corners>
StarNorms::StarNorms(Star<Corners> star, int valence)
    : reference_(reference_star<Corners>(valence)), norm_(reference_.size(), 0.0) {
    const std::size_t count = reference_.size();
    star.resize(Star<Corners>::with_first(valence));
    const auto for_each_deviation = [&](const auto& take) {
        constexpr int n = Corners;
        const Vec3d c0 = corner_limit(star, 0), by_x = corner_limit(star, 1) - c0,
                    by_y = corner_limit(star, n - 1) - c0,
                    twist = n == 4 ? corner_limit(star, 2) - c0 - by_x - by_y : Vec3d(0);
        const Parameters at =
            n == 4 ? Parameters{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}} : Parameters{{{0, 0}, {1, 0}, {0, 1}, {}}};
        take_star(star, at, 0, [&](const Vec3d& p, const Vec2d& q) {
            take(p - (c0 + q.x * by_x + q.y * by_y + q.x * q.y * twist));
        });
    };
    const auto note = [](double& most, double size) { most = std::max(most, size * k_rounding_of_sums); };
    // One coordinate per point: the weights of three points at a time.
    for (std::size_t first = 0; first < count; first += 3) {
        for (std::size_t i = 0; i < count; ++i) star.points[i] = Vec3d(i == first, i == first + 1, i == first + 2);
        for_each_deviation([&](const Vec3d& d) {
            for (std::size_t k = 0; k < 3 && first + k < count; ++k)
                note(norm_[first + k], std::abs(d[static_cast<int>(k)]));
        });
    }
    for (std::size_t i = 0; i < count; ++i) star.points[i] = Vec3d(reference_[i], 0);
    for_each_deviation([&](const Vec3d& d) { note(reference_deviation_, glm::length(d)); });
    // The affine map fits the reference star to a star by least squares.
    glm::dmat3 normal(0);
    for (const Vec2d& p : reference_) normal += glm::outerProduct(Vec3d(1, p.x, p.y), Vec3d(1, p.x, p.y));
    for (const Vec2d& p : reference_) fit_.push_back(glm::inverse(normal) * Vec3d(1, p.x, p.y));
}

template <int Corners>
const StarNorms* StarNorms::of(const Star<Corners>& star) {
    struct Slot {
        std::once_flag once;
        std::unique_ptr<const StarNorms> norms;
    };
    static std::array<Slot, k_most_valence + 1> known;
    const int valence = star.valence[0];
    if (star.valence != star.with_first(valence) || valence > k_most_valence) return nullptr;
    Slot& slot = known[static_cast<std::size_t>(valence)];
    std::call_once(slot.once, [&] { slot.norms.reset(new StarNorms(Star<Corners>(), valence)); });
    return slot.norms.get();
}

template const StarNorms* StarNorms::of(const QuadStar&);
template const StarNorms* StarNorms::of(const LoopStar&);

double StarNorms::deviation(std::span<const Vec3d> points) const {
    Vec3d at(0), x(0), y(0);
    for (std::size_t i = 0; i < fit_.size(); ++i) {
        at += fit_[i].x * points[i];
        x += fit_[i].y * points[i];
        y += fit_[i].z * points[i];
    }
    // The affine map stretches lengths at most by the larger singular value of its matrix.
    const double xx = glm::dot(x, x), yy = glm::dot(y, y), xy = glm::dot(x, y);
    const double stretch = std::sqrt(0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy));
    double sum = stretch * reference_deviation_;
    for (std::size_t i = 0; i < fit_.size(); ++i)
        sum += norm_[i] * glm::length(points[i] - (at + reference_[i].x * x + reference_[i].y * y));
    return sum * k_rounding_of_sums;
}

}  // namespace tetrakis::detail
