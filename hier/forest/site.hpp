#pragma once

#include "../base/ids.hpp"

#include <array>
#include <compare>
#include <cstdint>

namespace tetrakis {

/// Deepest lattice level of a site: coordinates are unsigned 32-bit and a side has 2^level intervals, so that its far
/// end must still fit.
inline constexpr int k_max_level = 30;

/// A point of a root's lattice. Quad family: x along v -> m(h), y along v -> m(prev h) of the corner cell Q(h), 0 <= x,
/// y <= 2^level. Triangle family: x along the face's first half-edge, y along its third one reversed, x + y <= 2^level.
struct LatticePoint {
    std::uint32_t x = 0, y = 0;
    friend constexpr auto operator<=>(const LatticePoint&, const LatticePoint&) = default;
};

/// Address of a vertex: root, level, lattice coordinates. A vertex on the border of roots has several addresses. One of
/// them is canonical (see corner_cell.hpp), and all tables keyed by sites use that one.
///
/// The lattice level of the quad family counts from the corner cell: lattice level l is Catmull-Clark level l + 1. In
/// the triangle family lattice level l is Loop level l, and a root is named by its face's first half-edge.
struct Site {
    HalfedgeId root;
    LatticePoint at;
    std::uint8_t level = 0;
    friend constexpr auto operator<=>(const Site&, const Site&) = default;
};
static_assert(sizeof(Site) == 16);

/// A triangle of a hierarchy: three lattice points of one root at one level, counter-clockwise. In the quad family a
/// depth-0 bisection leaf (v, w, c) reaches into two corner cells; it is written at level 0 in the frame of Q(h)
/// continued over its side x = N: v = (0, 0), w = (2, 0), c = (1, 1).
struct CellTriangle {
    HalfedgeId root;
    std::uint8_t level = 0;
    std::array<LatticePoint, 3> corner;
};

}  // namespace tetrakis
