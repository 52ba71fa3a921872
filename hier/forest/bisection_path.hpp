#pragma once

#include "../mesh/control_mesh.hpp"
#include "site.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tetrakis {

/// Deepest bisection: two bisections are one lattice level.
inline constexpr int k_max_bisection_depth = 2 * k_max_level;

/// The lattice level of a bisection triangle: the smallest at which its three corners are lattice points.
constexpr std::uint8_t lattice_level(int depth) { return static_cast<std::uint8_t>(depth >> 1); }

/// The shape of a bisection triangle (a, b, apex): right-angled and isosceles in the lattice, so the apex and the
/// direction from it to a say all. Directions count eighths of a turn counter-clockwise from +x: a = apex +
/// step(direction), b = apex + step(direction + 2). At odd depths they are even (legs along the lattice lines, one
/// interval long), at even depths odd (legs along diagonals). Depth 0 is written in the extended frame of CellTriangle.
struct BisectionShape {
    LatticePoint apex;
    std::uint8_t direction = 0;
    friend constexpr bool operator==(const BisectionShape&, const BisectionShape&) = default;

    /// Lattice steps of the eight directions, as unsigned numbers that wrap.
    static constexpr std::array<LatticePoint, 8> k_steps{
        {{1, 0}, {1, 1}, {0, 1}, {~0u, 1}, {~0u, 0}, {~0u, ~0u}, {0, ~0u}, {1, ~0u}}};

    static constexpr LatticePoint step(LatticePoint p, int direction) {
        const LatticePoint s = k_steps[static_cast<unsigned>(direction) & 7u];
        return {p.x + s.x, p.y + s.y};
    }
    constexpr LatticePoint a() const { return step(apex, direction); }
    constexpr LatticePoint b() const { return step(apex, direction + 2); }

    /// The middle of the base edge, at the lattice level of the children.
    constexpr LatticePoint middle(int depth) const {
        const int shift = depth & 1;  // from odd to even depth the lattice is refined
        return step({apex.x << shift, apex.y << shift}, direction + 1);
    }
    /// Child 0 is (apex, a, middle), child 1 is (b, apex, middle). From depth 0 child 1 lies in the next corner cell,
    /// whose frame is turned back by a quarter.
    constexpr BisectionShape child(int depth, int bit) const {
        if (depth == 0) return bit == 0 ? BisectionShape{{1, 0}, 2} : BisectionShape{{0, 1}, 6};
        return {middle(depth), static_cast<std::uint8_t>((direction + (bit == 0 ? 5 : 3)) & 7)};
    }
    /// Inverse of child(): `depth` and `bit` are the child's own.
    constexpr BisectionShape parent(int depth, int bit) const {
        if (depth == 1) return root();
        const LatticePoint old_apex = bit == 0 ? a() : b();
        const int shift = (depth & 1) == 0 ? 1 : 0;
        return {{old_apex.x >> shift, old_apex.y >> shift},
                static_cast<std::uint8_t>((direction + (bit == 0 ? 3 : 5)) & 7)};
    }
    /// The root triangle (v, w, c) in the extended frame: v = (0, 0), w = (2, 0), c = (1, 1).
    static constexpr BisectionShape root() { return {{1, 1}, 5}; }

    constexpr CellTriangle in(HalfedgeId cell, int depth) const {
        return {cell, lattice_level(depth), {a(), b(), apex}};
    }
};

/// A node of the bisection tree, written in the frame of a corner cell. The root h is the triangle (v, w, c) over the
/// half-edge h: v -> w of a face with centre c; bisecting (a, b, apex) at the middle m of its base a-b gives child 0
/// (apex, a, m) and child 1 (b, apex, m).
/// @param depth  number of bisections, 0 <= depth <= k_max_bisection_depth
/// @param path   the child taken at each bisection, the first in the most significant of `depth` bits
/// @return       corners (a, b, apex), counter-clockwise, at lattice level depth / 2. O(depth).
CellTriangle cell_triangle(const ControlMesh& mesh, HalfedgeId root, int depth, std::uint64_t path);

/// The canonical site of corner k of a bisection triangle; at depth 0 corner 1 lies in the next corner cell. O(1).
Site corner_site(const ControlMesh& mesh, const CellTriangle& triangle, std::size_t k);

}  // namespace tetrakis
