#include "quad_bounder.hpp"
#include "quad_remainder.hpp"

#include <algorithm>

// Pieces of cells with a crease of finite sharpness: strips along the crease, each one bicubic patch.

namespace tetrakis {

using detail::k_line_remainder;
using detail::k_rounding;
using detail::remainder_of;
using detail::WalkCell;

namespace {

/// Parts of a strip beside a crease are quartered this often before the cell is.
constexpr int k_strip_depth = 2;
}  // namespace

bool QuadBounder::bound_strips(WalkCell& cell, const Piece& piece, const Corners& corners) {
    const int k = piece.turn, k1 = (k + 1) & 3, k3 = (k + 3) & 3;
    const auto corner_at = [](int i) { return Vec2d(detail::k_corner_x[i], detail::k_corner_y[i]); };
    const int axis = cell.crease.side == 0 || cell.crease.side == 2 ? 1 : 0;  // across the crease
    const bool far = cell.crease.side == 1 || cell.crease.side == 2;
    struct Corner {
        Vec2d at;
        Vec3d linear;
        std::int8_t edge;  ///< to the next corner
        double distance;   ///< from the crease
    };
    constexpr std::size_t k_most = 5;  // corners of a triangle cut by two parallel lines
    using Polygon = std::array<Corner, k_most + 1>;
    Polygon whole;
    const std::array<Vec2d, 3> at = piece.quarter ? std::array<Vec2d, 3>{Vec2d(0.5), corner_at(k), corner_at(k1)}
                                                  : std::array<Vec2d, 3>{corner_at(k), corner_at(k1), corner_at(k3)};
    for (std::size_t i = 0; i < 3; ++i)
        whole[i] = {at[i], corners.linear[i], piece.edge[i], far ? 1 - at[i][axis] : at[i][axis]};
    // Keeps what lies on the one side (sign 1: at least) of the line at a distance from the crease.
    const auto clip = [](const Polygon& in, std::size_t count, double line, double sign, Polygon& out) {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const Corner &a = in[i], &b = in[(i + 1) % count];
            const double da = sign * (a.distance - line), db = sign * (b.distance - line);
            if (da >= 0) {
                out[kept] = a;
                if (da == 0 && db < 0) out[kept].edge = -1;
                ++kept;
            }
            if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
                const double t = da / (da - db);
                out[kept++] = {(1 - t) * a.at + t * b.at, (1 - t) * a.linear + t * b.linear,
                               da > 0 ? std::int8_t{-1} : a.edge, line};
            }
        }
        return kept;
    };
    const WalkCell::Strips& strips = cell.strips();
    for (std::size_t s = 0; s < static_cast<std::size_t>(strips.count); ++s) {
        const detail::CreaseStrip& strip = strips.strip[s];
        Polygon near, both;
        const std::size_t count = clip(near, clip(whole, 3, strip.begin, 1, near), strip.end, -1, both);
        if (count < 3) continue;
        std::array<Vec2d, k_most + 1> own;
        std::array<Vec3d, k_most + 1> surface;
        for (std::size_t i = 0; i < count; ++i) {
            own[i] = both[i].at;
            const double distance = (both[i].distance - strip.origin) / strip.span;
            own[i][axis] = far ? 1 - distance : distance;
            surface[i] = combine(strip.net, detail::cubic_basis(own[i].x), detail::cubic_basis(own[i].y));
        }
        for (std::size_t i = 1; i + 1 < count; ++i) {
            const Part part{{own[0], own[i], own[i + 1]},
                            {surface[0], surface[i], surface[i + 1]},
                            {both[0].linear, both[i].linear, both[i + 1].linear},
                            {i == 1 ? both[0].edge : std::int8_t{-1}, both[i].edge,
                             i + 2 == count ? both[i + 1].edge : std::int8_t{-1}}};
            if (!bound_part(strip.net, strips.third[s], part, k_strip_depth)) return false;
            if (rejected_) return true;
        }
    }
    return true;
}

bool QuadBounder::bound_part(const detail::Net16& net, const detail::ThirdBounds& third, const Part& part, int depth) {
    const double pad = k_rounding * scale_;
    std::array<Vec2d, 3> at;
    std::array<Vec3d, 3> surface, linear, corner, middle;
    Vec3d sum(0);
    double bulge = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        at[i] = 0.5 * (part.at[i] + part.at[j]);
        linear[i] = 0.5 * (part.linear[i] + part.linear[j]);
        surface[i] = combine(net, detail::cubic_basis(at[i].x), detail::cubic_basis(at[i].y));
        corner[i] = measured_form(part.surface[i], part.surface[i] - part.linear[i]);
        middle[i] = measured_form(surface[i], surface[i] - linear[i]);
        if (!attain(node_error(middle[i], part.edge[i]))) return true;
        const Vec3d e = surface[i] - 0.5 * (part.surface[i] + part.surface[j]);
        sum += e;
        bulge = std::max(bulge, glm::dot(e, e));
    }
    const Vec2d u = part.at[1] - part.at[0], v = part.at[2] - part.at[0];
    Remainder rest;
    rest.whole = rest.height = remainder_of(third.in_frame(u, v), 0, false);
    // The chords are no further off than the corners, and the quadratic's bulge over them is an edge's or half their
    // sum: that decides most parts.
    double at_corners = 0;
    for (std::size_t i = 0; i < 3; ++i)
        at_corners =
            std::max({at_corners, node_error(corner[i], part.edge[i]), node_error(corner[i], part.edge[(i + 2) % 3])});
    bulge = std::sqrt(std::max(bulge, 0.25 * glm::dot(sum, sum)));
    if (settled(at_corners + bulge + rest.whole + pad)) return true;
    if (distance_ && !triangle_.sliver())
        rest.height = remainder_of(detail::ThirdBounds::along(net, triangle_.normal()).in_frame(u, v), 0, false);
    for (std::size_t i = 0; i < 3; ++i)
        rest.edge[i] = k_line_remainder * third.on_line(part.at[(i + 1) % 3] - part.at[i]);
    if (settled(quadratic_error(corner, middle, part.edge, rest) + pad)) return true;
    if (depth == 0) return false;
    const auto sub = [&](std::size_t i) {
        // The quarter at corner i.
        const std::size_t k = (i + 2) % 3;
        return Part{{part.at[i], at[i], at[k]},
                    {part.surface[i], surface[i], surface[k]},
                    {part.linear[i], linear[i], linear[k]},
                    {part.edge[i], -1, part.edge[k]}};
    };
    for (std::size_t i = 0; i < 3; ++i)
        if (!bound_part(net, third, sub(i), depth - 1)) return false;
    return bound_part(net, third, {at, surface, linear, {-1, -1, -1}}, depth - 1);
}

}  // namespace tetrakis
