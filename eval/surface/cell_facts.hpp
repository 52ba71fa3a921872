#pragma once

#include "bicubic.hpp"

#include <array>

namespace tetrakis::detail {

/// Largest third derivatives of a smooth bicubic patch over its cell, by its parameters.
struct ThirdBounds {
    double xxx = 0, xxy = 0, xyy = 0, yyy = 0;

    static ThirdBounds of(const Net16& net);
    /// Of the component along a unit vector.
    static ThirdBounds along(const Net16& net, const Vec3d& direction);

    /// The same by the parameters of a frame u, v in this one's.
    ThirdBounds in_frame(const Vec2d& u, const Vec2d& v) const;
    /// The third derivative along a line, by the parameter that runs from 0 to 1 over d.
    double on_line(const Vec2d& d) const;
};

/// What bounds ask of a smooth regular cell again and again.
struct CellFacts {
    /// Limit positions at (column / 2, row / 2), number 3 * row + column: corners, middles of the sides, centre.
    std::array<Vec3d, 9> point;
    ThirdBounds third;

    void find_points(const Net16& net);
    void fill(const Net16& net) {
        find_points(net);
        third = ThirdBounds::of(net);
    }
};

}  // namespace tetrakis::detail
