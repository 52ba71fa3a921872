#pragma once

#include "../patches/bicubic.hpp"
#include "../patches/box_spline.hpp"

#include <array>
#include <span>

namespace tetrakis::detail {

/// 3 x 3 control points, row by row.
using Net9 = std::span<const Vec3d, 9>;

/// The surface of a regular cell over a triangle in its parameters as one polynomial: of a bicubic patch, Loop's box
/// spline, or a biquadratic patch (Doo-Sabin).
BezierTriangle<6> polynomial_over(const Net16& net, const std::array<Vec2d, 3>& triangle);
BezierTriangle<4> polynomial_over(const Net12& net, const std::array<Vec2d, 3>& triangle);
BezierTriangle<4> polynomial_over(const Net9& net, const std::array<Vec2d, 3>& triangle);

/// A cell of the box spline of Zwart and Powell (midedge) over a triangle in its parameters. The cell's diagonals cut
/// it in four, each with a polynomial of degree 2.
/// @param side  of the cell, 0 to 3: the triangle lies between that side and the centre
BezierTriangle<2> four_direction_over(const Net9& net, int side, const std::array<Vec2d, 3>& triangle);

}  // namespace tetrakis::detail
