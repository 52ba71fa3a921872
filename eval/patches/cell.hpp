#pragma once

#include "../../hier/base/vec.hpp"

#include <algorithm>
#include <array>

namespace tetrakis::detail {

// Points in a cell with n corners (3 or 4), whose sides have length 1. Quarter k lies at corner k of the cell, which is
// also corner k of the quarter. Quarter 3 of a triangle is the central one; its corner k is opposite corner k.

/// Corner k: (0, 0), (1, 0), (1, 1), (0, 1); of a triangle (0, 0), (1, 0), (0, 1).
inline Vec2d cell_corner(int k, int n) { return n == 4 ? Vec2d(k == 1 || k == 2, k >= 2) : Vec2d(k == 1, k == 2); }
inline bool is_cell_corner(const Vec2d& p) { return (p.x == 0 || p.x == 1) && (p.y == 0 || p.y == 1); }
inline bool is_in_cell(const Vec2d& p, int n) {
    return p.x >= 0 && p.y >= 0 && (n == 4 ? p.x <= 1 && p.y <= 1 : p.x + p.y <= 1);
}
/// Weights of the cell's corners in a point: bilinear in quads, barycentric in triangles.
inline std::array<double, 4> corner_weights(const Vec2d& p, int n) {
    const double x = p.x, y = p.y;
    if (n == 3) return {1 - x - y, x, y, 0};
    return {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
}
/// Number of the quarter that contains a point.
inline int quarter_of(const Vec2d& p, int n) {
    if (n == 4) return p.y < 0.5 ? p.x >= 0.5 : p.x < 0.5 ? 3 : 2;
    return p.x >= 0.5 ? 1 : p.y >= 0.5 ? 2 : p.x + p.y < 0.5 ? 0 : 3;
}
/// Coordinates in a quarter of a point of the cell; exact for lattice points.
inline Vec2d in_quarter(const Vec2d& p, int quarter, int n) {
    return quarter < n ? 2.0 * p - cell_corner(quarter, n) : Vec2d(1) - 2.0 * p;
}
/// Whether all corners of a triangle are corners of quarters: of those that leaves have in irregular cells, nearly all.
inline bool is_common(const std::array<Vec2d, 3>& triangle) {
    const auto is_half = [](double x) { return x == 0 || x == 0.5 || x == 1; };
    return std::ranges::all_of(triangle, [&](const Vec2d& p) { return is_half(p.x) && is_half(p.y); });
}
/// Coordinates of a point of the cell as seen from one of its corners, which becomes (0, 0).
inline Vec2d turned(Vec2d p, int corner, int n) {
    for (int k = 0; k < corner; ++k) p = {p.y, 1 - p.x - (n == 3 ? p.y : 0)};
    return p;
}

}  // namespace tetrakis::detail
