#pragma once

#include "../../hier/base/vec.hpp"

#include <array>

namespace tetrakis::detail {

// Places in a cell with n corners (3 or 4), in lengths of its sides. Its quarters are numbered as the corners that they
// are at, with the same corner there; the last of a triangle is the middle one, whose corner k lies opposite corner k.

/// Corner k: (0, 0), (1, 0), (1, 1), (0, 1); of a triangle (0, 0), (1, 0), (0, 1).
inline Vec2d cell_corner(int k, int n) { return n == 4 ? Vec2d(k == 1 || k == 2, k >= 2) : Vec2d(k == 1, k == 2); }
inline bool is_cell_corner(const Vec2d& p) { return (p.x == 0 || p.x == 1) && (p.y == 0 || p.y == 1); }
inline bool is_in_cell(const Vec2d& p, int n) {
    return p.x >= 0 && p.y >= 0 && (n == 4 ? p.x <= 1 && p.y <= 1 : p.x + p.y <= 1);
}
/// A point of the cell by weights of its corners, bilinear or linear.
inline std::array<double, 4> corner_weights(const Vec2d& p, int n) {
    const double x = p.x, y = p.y;
    if (n == 3) return {1 - x - y, x, y, 0};
    return {(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
}
/// Which quarter a point is in.
inline int quarter_of(const Vec2d& p, int n) {
    if (n == 4) return p.y < 0.5 ? p.x >= 0.5 : p.x < 0.5 ? 3 : 2;
    return p.x >= 0.5 ? 1 : p.y >= 0.5 ? 2 : p.x + p.y < 0.5 ? 0 : 3;
}
/// A point in a quarter's own sides; exact for lattice points.
inline Vec2d in_quarter(const Vec2d& p, int quarter, int n) {
    return quarter < n ? 2.0 * p - cell_corner(quarter, n) : Vec2d(1) - 2.0 * p;
}

}  // namespace tetrakis::detail
