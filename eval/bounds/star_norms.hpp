#pragma once

#include "../../hier/base/vec.hpp"
#include "../patches/star.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// How far the surface S of a cell at an extraordinary vertex is from L, the function with its values at the cell's
/// corners, bilinear or on a triangle linear: S - L is linear in the points around the cell, and zero where they are
/// all one. So it is at most the sum over the points of what each lies off an affine image of a reference star, times
/// the largest its own weight in S - L grows to; and what the reference star's own S - L is under that affine map.
/// Norms depend on the valences alone.
class StarNorms {
  public:
    /// Of a star with one extraordinary corner, of valence 3 to 32; null for others. Found at the first call, from any
    /// thread.
    template <int Corners>
    static const StarNorms* of(const Star<Corners>& star);

    /// Upper bound on |S - L|; but for rounding.
    double deviation(std::span<const Vec3d> points) const;

  private:
    template <int Corners>
    StarNorms(Star<Corners> star, int valence);

    std::vector<Vec2d> reference_;    ///< the reference star's points
    std::vector<Vec3d> fit_;          ///< weights of a star's points in its affine map
    std::vector<double> norm_;        ///< by point
    double reference_deviation_ = 0;  ///< the reference star's S - L
};

}  // namespace tetrakis::detail
