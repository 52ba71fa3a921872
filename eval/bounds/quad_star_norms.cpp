#include "../patches/quad_star.hpp"
#include "star_norms.hpp"

#include <glm/matrix.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>

namespace tetrakis::detail {

namespace {

constexpr int k_most_valence = 32, k_triangles = 8;
/// Steps to the innermost star, and how often regular cells of the first one are cut up; one time less in each further.
constexpr int k_steps = 10, k_cuts = 2;
constexpr std::array<std::array<double, 2>, 4> k_corner = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

/// A part of a cell: its corner at (0, 0) and its sides' length, in sides of the cell; in frames turned by half counted
/// from the far corner.
struct Square {
    double x = 0, y = 0, side = 1;
};

/// An affine function of a point in the parameters.
template <class Value>
struct Affine {
    Value at_origin, by_x, by_y;

    Value operator()(double x, double y) const { return at_origin + x * by_x + y * by_y; }
    Affine turned() const { return {(*this)(1, 1), -by_x, -by_y}; }
};

/// A triangle of the parameters, and the affine function with the values of S at its corners.
struct Linear {
    Affine<Vec3d> weights;  ///< barycentrics
    Affine<Vec3d> value;

    Linear() = default;
    Linear(const std::array<Vec2d, 3>& at, const std::array<Vec3d, 3>& values) {
        const glm::dmat3 corners(Vec3d(at[0], 1), Vec3d(at[1], 1), Vec3d(at[2], 1)), inverse = glm::inverse(corners);
        const glm::dmat3 of = glm::dmat3(values[0], values[1], values[2]) * inverse;
        weights = {inverse[2], inverse[0], inverse[1]};
        value = {of[2], of[0], of[1]};
    }
    /// Whether all of a square lies beyond one side.
    bool misses(const Square& s) const {
        Vec3d most(0);
        for (const auto& c : k_corner) most = glm::max(most, weights(s.x + c[0] * s.side, s.y + c[1] * s.side));
        return std::min({most.x, most.y, most.z}) <= 1e-9;
    }
};

/// Bezier control points of a cell, row by row.
std::array<Vec3d, 16> bezier_points(const Net16& net) {
    const auto along = [](const Vec3d& a, const Vec3d& b, const Vec3d& c, const Vec3d& d) {
        return std::array<Vec3d, 4>{(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0,
                                    (b + 4.0 * c + d) / 6.0};
    };
    std::array<std::array<Vec3d, 4>, 4> rows;
    for (int y = 0; y < 4; ++y)
        rows[static_cast<std::size_t>(y)] =
            along(net.at(-1, y - 1), net.at(0, y - 1), net.at(1, y - 1), net.at(2, y - 1));
    std::array<Vec3d, 16> points;
    for (std::size_t x = 0; x < 4; ++x) {
        const auto column = along(rows[0][x], rows[1][x], rows[2][x], rows[3][x]);
        for (std::size_t y = 0; y < 4; ++y) points[4 * y + x] = column[y];
    }
    return points;
}

/// As StarNorms asks for.
template <class Take>
class Deviations {
  public:
    Deviations(const QuadStar& star, const Take& take) : take_(take) {
        QuadStar near;
        StarQuarters quarters;
        subdivide(star, near, quarters);
        const Vec3d centre = regular_position(quarters.net[1], {}, 0, 1);
        const auto corner = [](std::size_t k) { return Vec2d(k_corner[k & 3][0], k_corner[k & 3][1]); };
        const auto limit = [&](std::size_t k) { return star.corner_limit(static_cast<int>(k & 3)); };
        for (std::size_t t = 0; t < 4; ++t) {
            linear_[t] = Linear({corner(t), corner(t + 1), corner(t + 3)}, {limit(t), limit(t + 1), limit(t + 3)});
            linear_[4 + t] = Linear({Vec2d(0.5), corner(t), corner(t + 1)}, {centre, limit(t), limit(t + 1)});
        }
        visit(star, {}, 0);
    }

  private:
    void visit(const QuadStar& star, const Square& square, int step) {
        if (step == k_steps) {
            for_each_triangle(square, [&](int triangle, const Linear& linear) {
                for (const Vec3d& p : star.points)
                    for (const auto& c : k_corner)
                        take_(static_cast<std::size_t>(triangle),
                              p - linear.value(square.x + c[0] * square.side, square.y + c[1] * square.side));
            });
            return;
        }
        QuadStar near;
        StarQuarters quarters;
        subdivide(star, near, quarters);
        for (std::size_t k = 0; k < 4; ++k) {
            const double half = 0.5 * square.side;
            const Square quarter{square.x + k_corner[k][0] * half, square.y + k_corner[k][1] * half, half};
            if (k == 0 && star.valence != 4)
                visit(near, quarter, step + 1);
            else if (k == 2 && star.far_valence != 4)
                visit_far(quarters.far, quarter, step + 1);
            else
                visit(quarters.net[k], quarter, k_cuts - step);
        }
    }
    /// A star at a far corner stands in its frame turned by half.
    void visit_far(const QuadStar& star, const Square& square, int step) {
        turn();
        visit(star, {1 - square.x - square.side, 1 - square.y - square.side, square.side}, step);
        turn();
    }
    void turn() {
        for (Linear& linear : linear_) {
            linear.weights = linear.weights.turned();
            linear.value = linear.value.turned();
        }
    }
    void visit(const Net16& net, const Square& square, int cuts) {
        if (cuts > 0) {
            const double half = 0.5 * square.side;
            for (int k = 0; k < 4; ++k) {
                Net16 child;
                child_net(net, k & 1, k >> 1, child);
                visit(child, {square.x + (k & 1) * half, square.y + (k >> 1) * half, half}, cuts - 1);
            }
            return;
        }
        const std::array<Vec3d, 16> points = bezier_points(net);
        for_each_triangle(square, [&](int triangle, const Linear& linear) {
            const double third = square.side / 3;
            for (std::size_t i = 0; i < 16; ++i)
                take_(static_cast<std::size_t>(triangle),
                      points[i] - linear.value(square.x + double(i % 4) * third, square.y + double(i / 4) * third));
        });
    }
    template <class Visit>
    void for_each_triangle(const Square& square, Visit&& visit) {
        for (int t = 0; t < k_triangles; ++t)
            if (const Linear& linear = linear_[static_cast<std::size_t>(t)]; !linear.misses(square)) visit(t, linear);
    }

    const Take& take_;
    std::array<Linear, k_triangles> linear_;
};

/// A flat star whose faces around each of the two corners are alike.
std::vector<Vec2d> reference_star(int valence, int far_valence) {
    const double at_near = std::numbers::pi / valence, at_far = std::numbers::pi / far_valence;
    const auto polar = [](double radius, double angle) { return radius * Vec2d(std::cos(angle), std::sin(angle)); };
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

std::unique_ptr<const StarNorms> norms_of(int valence, int far_valence) {
    return std::make_unique<const StarNorms>(reference_star(valence, far_valence), k_triangles,
                                             [&](std::span<const Vec3d> points, const auto& take) {
                                                 QuadStar star;
                                                 star.resize(valence, far_valence);
                                                 for (std::size_t i = 0; i < points.size(); ++i)
                                                     star.points[i] = points[i];
                                                 star.find_limit();
                                                 Deviations(star, take);
                                             });
}

}  // namespace

const StarNorms* StarNorms::catmull_clark(int valence, int far_valence) {
    if (std::min(valence, far_valence) < 3 || std::max(valence, far_valence) > k_most_valence) return nullptr;
    constexpr std::size_t k_count = k_most_valence + 1;
    static std::array<std::atomic<const StarNorms*>, k_count * k_count> known{};
    auto& slot = known[static_cast<std::size_t>(valence) * k_count + static_cast<std::size_t>(far_valence)];
    return find_or_make(slot, [&] { return norms_of(valence, far_valence); });
}

}  // namespace tetrakis::detail
