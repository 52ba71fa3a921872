#pragma once

#include "../surface/box_spline.hpp"
#include "bezier_triangle.hpp"

namespace tetrakis::detail {

/// A regular triangle of a Loop surface: a polynomial of degree 4.
BezierTriangle<4> box_spline_triangle(const Net12& net);

/// Bound on |S - L|, L the linear interpolant of the corners. A triangle within whose sides are those of this one times
/// h has at most h^2 times that.
double linear_deviation(const BezierTriangle<4>& patch);

}  // namespace tetrakis::detail
