#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace tetrakis::detail {

/// A point of a lattice that carries 4-8 triangles. The diagonals of its finest squares run through the points whose
/// two coordinates are even.
struct LatticePlace {
    std::int32_t x = 0, y = 0;
};

/// The two triangles at an edge, by the lattice points of their corners.
struct LatticeDiamond {
    LatticePlace middle;
    std::int32_t step = 0;   ///< side of the largest squares of which the middle is a corner
    bool is_centre = false;  ///< of a square with four corners, `step` away along both axes; else `step` along one
    std::array<LatticePlace, 2> ends{}, apexes{};

    explicit LatticeDiamond(LatticePlace p)
        : middle(p), step(1 << std::countr_zero(static_cast<std::uint32_t>(p.x | p.y))) {
        const bool odd_x = (p.x & step) != 0, odd_y = (p.y & step) != 0;
        const std::int32_t s = step;
        is_centre = odd_x && odd_y;
        if (is_centre) {
            // The base is the diagonal from the centre of the next larger squares.
            const auto is_end = [&](std::int32_t x, std::int32_t y) { return (x & 2 * s) != 0 && (y & 2 * s) != 0; };
            const bool falls = is_end(p.x - s, p.y - s) || is_end(p.x + s, p.y + s);
            ends = {{{p.x - s, falls ? p.y - s : p.y + s}, {p.x + s, falls ? p.y + s : p.y - s}}};
            apexes = {{{p.x - s, falls ? p.y + s : p.y - s}, {p.x + s, falls ? p.y - s : p.y + s}}};
        } else {
            const LatticePlace along{odd_x ? s : 0, odd_x ? 0 : s}, aside{along.y, along.x};
            ends = {{{p.x - along.x, p.y - along.y}, {p.x + along.x, p.y + along.y}}};
            apexes = {{{p.x - aside.x, p.y - aside.y}, {p.x + aside.x, p.y + aside.y}}};
        }
    }
    /// Middles of the diamonds that a split makes possible. Of no use for a finest one: they are no lattice points.
    std::array<LatticePlace, 4> children() const {
        const auto [x, y] = middle;
        const std::int32_t s = step, h = step / 2;
        if (is_centre) return {{{x - s, y}, {x + s, y}, {x, y - s}, {x, y + s}}};
        return {{{x - h, y - h}, {x + h, y - h}, {x - h, y + h}, {x + h, y + h}}};
    }
    /// Steps along both axes from the middle that hold this diamond and all diamonds that its splits lead to.
    std::int32_t reach() const { return reach(middle); }
    static std::int32_t reach(LatticePlace middle) {
        const std::int32_t bits = middle.x | middle.y, step = bits & -bits;
        return (middle.x & middle.y & step) != 0 ? 3 * step : 2 * step;
    }
};

}  // namespace tetrakis::detail
