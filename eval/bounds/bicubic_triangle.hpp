#pragma once

#include "../surface/bicubic.hpp"
#include "bezier_triangle.hpp"

namespace tetrakis::detail {

/// A bicubic patch over a triangle in its parameters: a polynomial of degree 6.
BezierTriangle<6> bicubic_over(const Net16& net, const std::array<Vec2d, 3>& triangle);

}  // namespace tetrakis::detail
