#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <limits>

namespace tetrakis {

namespace detail {

/// Rounding of a patch's control points and of distances, in units of the largest coordinate: fewer than 100 operations
/// on values not larger than it, each off by half an ulp at most.
inline constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

}  // namespace detail

/// What is known of the distance between a surface and a triangle of a hierarchy.
struct LeafError {
    double lower = 0;  ///< attained at a sample
    double upper = 0;  ///< never exceeded (rounding included)
};

/// A first look at a leaf: what the cheap filters need.
struct QuickError {
    std::array<Vec3d, 3> corners;  ///< limit positions of corners 0, 1, 2
    Vec3d middle{0};               ///< S - L at the middle of the edge corner 0 - corner 1
};

}  // namespace tetrakis
