#pragma once

#include "../../hier/base/vec.hpp"
#include "bezier_triangle.hpp"

#include <array>

namespace tetrakis::detail {

/// Barycentric coordinates in a triangle; they sum to one.
using Bary = std::array<double, 3>;
inline Bary bary(const Vec2d& p) { return {1 - p.x - p.y, p.x, p.y}; }

/// The 12 control points around a regular triangle of a Loop mesh (quartic box spline, each direction twice). With the
/// triangle's corners at (0,0) (1,0) (0,1) of the triangular lattice: [0..2] are the corners; [3..6] (-1,1) (-1,0)
/// (0,-1) (1,-1) complete the ring of (0,0), counter-clockwise; [7..9] (2,-1) (2,0) (1,1) complete the ring of (1,0);
/// [10, 11] (0,2) (-1,2) complete the ring of (0,1).
using Net12 = std::array<Vec3d, 12>;

/// The patch as a polynomial of degree 4. Source: Stam 1998 (subdivision surfaces of Loop), appendix A, in another
/// order.
BezierTriangle<4> box_spline_triangle(const Net12& net);

Vec3d box_spline_position(const Net12& net, const Bary& at);

/// Position at a corner of the triangle: half the point there and a twelfth of each of its neighbours.
Vec3d box_spline_corner(const Net12& net, int corner);

}  // namespace tetrakis::detail
