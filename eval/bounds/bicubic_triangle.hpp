#pragma once

#include "../surface/bicubic.hpp"
#include "bezier_triangle.hpp"

namespace tetrakis::detail {

/// A bicubic patch over a triangle in its parameters is a polynomial of degree 6: the weights of the net's points, in
/// its order, in the control points of the polynomial.
using SexticWeights = std::array<std::array<double, BezierTriangle<6>::k_count>, 16>;
SexticWeights sextic_weights(const std::array<Vec2d, 3>& triangle);

BezierTriangle<6> bicubic_over(const Net16& net, const SexticWeights& weights);

}  // namespace tetrakis::detail
