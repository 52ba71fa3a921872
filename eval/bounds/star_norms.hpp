#pragma once

#include "../patches/quad_star.hpp"

#include <array>
#include <vector>

namespace tetrakis::detail {

/// How far the surface S of a star (QuadStar) is from its linear interpolant L over a triangle of the cell: S - L is
/// linear in the star's points, and zero where they are all one. So it is at most the sum over the points of what each
/// lies off an affine image of a reference star, times the largest its own weight in S - L grows to; and what the
/// reference star's own S - L is under that affine map. Norms depend on the valences alone.
class StarNorms {
  public:
    /// Triangles, seen from the star: half the cell at corner t (corners t, t + 1, t + 3) is number t, the quarter
    /// (corners: the cell's centre, t, t + 1) number 4 + t.
    static constexpr int k_triangles = 8;

    /// Those of a star of these valences, found at the first call, any thread; null where a valence is less than 3 or
    /// more than 32.
    static const StarNorms* of(int valence, int far_valence);

    /// Upper bound on |S - L| over a triangle, L with the values of S at its corners; but for rounding.
    double deviation(const QuadStar& star, int triangle) const;

  private:
    StarNorms(int valence, int far_valence);

    std::vector<Vec2d> reference_;                           ///< the reference star's points
    std::vector<Vec3d> fit_;                                 ///< weights of a star's points in its affine map
    std::array<std::vector<double>, k_triangles> norm_;      ///< by point
    std::array<double, k_triangles> reference_deviation_{};  ///< its S - L
};

}  // namespace tetrakis::detail
