#pragma once

#include "../../hier/base/vec.hpp"
#include "../patches/star.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// Bounds |S - L| over a cell at an extraordinary vertex: S is its surface, L the function with S's corner values,
/// bilinear or on a triangle linear. S - L is linear in the points around the cell, and zero if they are all equal.
/// Split the points into an affine image of a reference star, and remainders. |S - L| is at most the sum over points of
/// remainder length times largest |weight| in S - L, plus the reference star's |S - L| times the affine map's stretch.
/// Norms depend on the valences alone.
class StarNorms {
  public:
    /// Norms for a star whose corner 0 has a valence of 3 to 32 and whose other corners are regular; null for others.
    /// They are computed at the first call. Thread-safe.
    template <int Corners>
    static const StarNorms* of(const Star<Corners>& star);

    /// Upper bound on |S - L|, except for rounding.
    double deviation(std::span<const Vec3d> points) const;

  private:
    template <int Corners>
    StarNorms(Star<Corners> star, int valence);

    std::vector<Vec2d> reference_;    ///< the reference star's points
    std::vector<Vec3d> fit_;          ///< weights of a star's points in its affine map
    std::vector<double> norm_;        ///< per point: largest |weight| in S - L
    double reference_deviation_ = 0;  ///< the reference star's largest |S - L|
};

}  // namespace tetrakis::detail
