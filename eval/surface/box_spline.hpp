#pragma once

#include "../../hier/base/vec.hpp"

#include <array>

namespace tetrakis::detail {

/// Barycentric coordinates in a triangle; they sum to one.
using Bary = std::array<double, 3>;

/// The 12 control points around a regular triangle of a Loop mesh (quartic box spline, directions each twice). With the
/// triangle's corners at (0,0) (1,0) (0,1) of the triangular lattice:
/// [0..2] the corners; [3..6] (-1,1) (-1,0) (0,-1) (1,-1): the rest of the ring of (0,0), counter-clockwise; [7..9]
/// (2,-1) (2,0) (1,1): of (1,0); [10, 11] (0,2) (-1,2): of (0,1).
using Net12 = std::array<Vec3d, 12>;

/// Weights of the 12 points for the position at a point of the triangle. Source: Stam 1998 (subdivision surfaces of
/// Loop), appendix A, in another order.
std::array<double, 12> box_spline_weights(const Bary& at);

Vec3d box_spline_position(const Net12& net, const Bary& at);

/// Position at a corner of the triangle: half the point there and a twelfth of each of its neighbours.
Vec3d box_spline_corner(const Net12& net, int corner);

/// First derivatives by x (towards corner 1) and y (towards corner 2).
struct BoxSplineTangents {
    Vec3d dx, dy;
};
BoxSplineTangents box_spline_tangents(const Net12& net, const Bary& at);

/// Position and derivatives by x and y.
struct BoxSplinePoint {
    Vec3d position, dx, dy, dxx, dxy, dyy;
};
BoxSplinePoint box_spline_point(const Net12& net, const Bary& at);

/// All second derivatives of a regular triangle. Along edge e (corner e to corner e + 1) the second derivative is the
/// bilinear box spline of the net's second differences along the edge (de Boor, Hoellig, Riemenschneider 1993, ch. I),
/// and on the triangle that is: linear between the differences at the corners, plus the product of the barycentric
/// coordinates of the edge's two ends times one fourth difference.
struct BoxSplineHessian {
    std::array<std::array<Vec3d, 3>, 3> corner;  ///< [edge][corner]
    std::array<Vec3d, 3> bend;                   ///< [edge]

    explicit BoxSplineHessian(const Net12& net);
    Vec3d along(int edge, const Bary& b) const {
        return b[0] * corner[edge][0] + b[1] * corner[edge][1] + b[2] * corner[edge][2] +
               (b[edge] * b[edge == 2 ? 0 : edge + 1]) * bend[edge];
    }
};

}  // namespace tetrakis::detail
