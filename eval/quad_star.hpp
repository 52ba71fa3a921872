#pragma once

#include "tetrakis/eval/bicubic.hpp"

#include <array>
#include <vector>

namespace tetrakis::detail {

/// The 2n + 8 points around a cell with one extraordinary, smooth, interior corner of valence n (Stam 1998), in the
/// cell's frame turned so that this corner is (0, 0).
///
/// points: [0] the corner; [1 + 2i] its edge neighbours e_i and [2 + 2i] the face points f_i between e_i and e_(i+1),
/// counter-clockwise, e_0 = (1, 0), f_0 = (1, 1), e_1 = (0, 1); [2n + 1 ..] the outer seven (2,-1) (2,0) (2,1) (2,2)
/// (1,2) (0,2) (-1,2).
struct QuadStar {
    int valence = 0;
    std::vector<Vec3d> points;

    static std::size_t point_count(int valence) { return 2 * static_cast<std::size_t>(valence) + 8; }
    Vec3d edge(int i) const { return points[1 + 2 * wrap(i)]; }
    Vec3d face(int i) const { return points[2 + 2 * wrap(i)]; }
    Vec3d outer(int i) const { return points[2 * valence + 1 + i]; }
    int wrap(int i) const { return (i % valence + valence) % valence; }
};

/// One Catmull-Clark step: the cell at the extraordinary corner (again a star) and the nets of the three regular
/// quarters, in the star's frame: regular[0] = (1, 0), [1] = (1, 1), [2] = (0, 1).
void subdivide(const QuadStar& star, QuadStar& child, std::array<Net16, 3>& regular);

}  // namespace tetrakis::detail
