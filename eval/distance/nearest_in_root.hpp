#pragma once

#include "../surface/surface_point.hpp"

#include <algorithm>
#include <cmath>
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

/// The parameters of one root: the unit square, or the triangle x, y >= 0, x + y <= 1.
enum class RootShape { square, triangle };

/// The surface at (x, y) with derivatives by x and y: at extraordinary points, where there are tangents alone, those of
/// a point a little further inside.
template <class Evaluate>
SurfacePoint with_derivatives(RootShape shape, double x, double y, Evaluate&& evaluate) {
    SurfacePoint s = evaluate(x, y);
    if (s.has_derivatives) return s;
    constexpr double k_inside = 1e-3;
    const double middle = shape == RootShape::square ? 0.5 : 1.0 / 3;
    SurfacePoint beside = evaluate(x + k_inside * (middle - x), y + k_inside * (middle - y));
    beside.position = s.position;
    return beside;
}

/// The direction of descent at s towards q that leaves the domain nowhere: Gauss-Newton in the plane, along a side that
/// holds it back, or none (false).
inline bool feasible_step(RootShape shape, const SurfacePoint& s, const Vec3d& q, double x, double y, double& dx,
                          double& dy) {
    const Vec3d r = q - s.position;
    const auto along = [&](const Vec3d& d) {
        const double square = glm::dot(d, d);
        return square > 0 ? glm::dot(d, r) / square : 0.0;
    };
    // A step to a side ends there but for rounding.
    constexpr double k_on = 1e-12;
    const auto blocked = [&](double ax, double ay) {
        if ((x <= k_on && ax < 0) || (y <= k_on && ay < 0)) return true;
        if (shape == RootShape::square) return (x >= 1 - k_on && ax > 0) || (y >= 1 - k_on && ay > 0);
        return x + y >= 1 - k_on && ax + ay > 0;
    };
    if (tangent_step(s, q, dx, dy) && !blocked(dx, dy)) return true;
    // Along the sides that hold it back, or along the tangents where they are parallel; the one that leads nearest.
    double best = 0;
    bool found = false;
    const auto look = [&](double ux, double uy, const Vec3d& d) {
        const double t = along(d), gain = std::abs(glm::dot(d, r)) * std::abs(t);
        if (t == 0 || blocked(t * ux, t * uy) || gain <= best) return;
        best = gain, dx = t * ux, dy = t * uy, found = true;
    };
    look(1, 0, s.du);
    look(0, 1, s.dv);
    if (shape == RootShape::triangle) look(-1, 1, s.dv - s.du);
    return found;
}

/// Distance from q to the part of the surface over one root, by descent from the best points of lattices: never below
/// the true distance, and above it only where the descent ends in another minimum.
/// @param smooth    it is one polynomial; if not, it may turn ever more tightly towards its corners, and so lattices of
///                  starts get finer towards them
/// @param evaluate  the surface at (x, y) of the root
/// @param position  its position alone
template <class Evaluate, class Position>
double nearest_in_root(RootShape shape, bool smooth, const Vec3d& q, Evaluate&& evaluate, Position&& position) {
    constexpr int n = 4;  // intervals a side of a lattice
    constexpr int k_finer = 4;
    constexpr double outside = std::numeric_limits<double>::infinity();
    constexpr int k_steps = 24, k_halvings = 12;
    double best = outside;
    const auto descend = [&](double x, double y, double distance) {
        SurfacePoint s = with_derivatives(shape, x, y, evaluate);
        for (int step = 0; step < k_steps; ++step) {
            double dx = 0, dy = 0;
            if (!feasible_step(shape, s, q, x, y, dx, dy)) break;
            // As far as the domain reaches, and as it gets nearer.
            double t = 1;
            const auto reach = [&](double at, double d) {
                if (d < 0) t = std::min(t, at / -d);
            };
            reach(x, dx), reach(y, dy);
            if (shape == RootShape::square)
                reach(1 - x, -dx), reach(1 - y, -dy);
            else
                reach(1 - x - y, -dx - dy);
            const double before = distance;
            for (int halving = 0; halving < k_halvings; ++halving, t *= 0.5) {
                const double nx = std::clamp(x + t * dx, 0.0, 1.0);
                const double ny = std::clamp(y + t * dy, 0.0, shape == RootShape::square ? 1.0 : 1 - nx);
                const double there = glm::length(q - position(nx, ny));
                if (there >= distance) continue;
                x = nx, y = ny, s = with_derivatives(shape, x, y, evaluate), distance = there;
                break;
            }
            if (distance >= before * (1 - 1e-12)) break;
        }
        best = std::min(best, distance);
    };
    const auto last = [&](int j) { return shape == RootShape::square ? n : n - j; };
    // The lattice over a copy of the domain, so many times smaller, at a corner.
    const auto search = [&](const Vec2d& corner, double size) {
        const auto at = [&](int i, int j) { return corner + size * (Vec2d(i, j) / static_cast<double>(n) - corner); };
        double lattice[n + 3][n + 3];
        for (auto& row : lattice) std::fill(std::begin(row), std::end(row), outside);
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= last(j); ++i) {
                const Vec2d p = at(i, j);
                lattice[j + 1][i + 1] = glm::length(q - position(p.x, p.y));
            }
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= last(j); ++i) {
                double around = outside;
                for (int b = 0; b < 3; ++b)
                    for (int a = 0; a < 3; ++a)
                        if (a != 1 || b != 1) around = std::min(around, lattice[j + b][i + a]);
                const double distance = lattice[j + 1][i + 1];
                if (distance <= around) descend(at(i, j).x, at(i, j).y, distance);
            }
    };
    search(Vec2d(0), 1);
    if (smooth) return best;
    constexpr Vec2d k_corners[4] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    for (const Vec2d& corner : k_corners) {
        if (shape == RootShape::triangle && corner == Vec2d(1)) continue;
        for (int level = 1; level <= k_finer; ++level) search(corner, std::ldexp(1.0, -level));
    }
    return best;
}

}  // namespace tetrakis::detail
