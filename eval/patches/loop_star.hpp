#pragma once

#include "../../schemes/rules/loop.hpp"
#include "box_spline.hpp"

#include <span>

namespace tetrakis::detail {

/// The n + 6 points around a triangle whose corner (0,0) is an interior smooth vertex of valence n and whose other
/// corners are regular (Stam 1998), in the order of Net12 with a ring of n: [0] the corner; [1..n] its ring
/// counter-clockwise, [1] = (1,0), [2] = (0,1); then (2,-1) (2,0) (1,1) (0,2) (-1,2).
constexpr int loop_star_size(int valence) { return valence + 6; }

/// One Loop step of a star: n + 12 points. The first n + 6 are the star of the quarter at the extraordinary corner, at
/// half the size; then, in its lattice, (3,-1) (3,0) (2,1) (1,2) (-1,3) (0,3), which complete the nets of the three
/// regular quarters.
constexpr int loop_star_step_size(int valence) { return valence + 12; }

/// @param star  loop_star_size(valence) points
/// @param step  receives loop_star_step_size(valence) points
void loop_star_step(int valence, double beta, const Vec3d* star, Vec3d* step);

/// Net of a regular quarter from a step: quarter 1 is (mid01, corner 1, mid12), 2 is (mid02, mid12, corner 2), 3 the
/// centre (mid12, mid02, mid01).
void loop_star_quarter(int valence, const Vec3d* step, int quarter, Net12& out);
inline Net12 loop_star_quarter(int valence, const Vec3d* step, int quarter) {
    Net12 out;
    loop_star_quarter(valence, step, quarter, out);
    return out;
}

/// Limit position of the extraordinary corner.
Vec3d loop_star_limit(int valence, const Vec3d* star);
/// Limit position of a regular corner, 1 or 2.
Vec3d loop_star_corner(int valence, const Vec3d* star, int corner);

/// Loop::beta() and Loop::limit_mask() of a valence, without their cosines where a table has them.
struct LoopVertexRule {
    double beta = 0;
    RingMask limit;
};
LoopVertexRule loop_vertex_rule(int valence);

}  // namespace tetrakis::detail
