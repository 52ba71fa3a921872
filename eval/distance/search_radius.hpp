#pragma once

#include "../surface/local_frame.hpp"

#include <limits>

namespace tetrakis::detail {

// Embree computes squared box distances in float: one rounding in each difference of coordinates, five in squares and
// sum, one in the squared radius; together below 8 * 2^-24 relative in the square, 2^-22 in the distance. Four times
// that also covers the double roundings of the local frame.
inline constexpr double k_radius_inflation = 0x1p-20;

// Squares and sums of local coordinates up to this stay finite in float.
inline constexpr double k_farthest_float_query = 0x1p60;

/// A float radius that misses nothing within `distance` (in local units) of the exact query point, when `slack` bounds
/// how far float rounding moved the query point and the primitives.
inline float search_radius(double distance, double slack) {
    const double radius = (distance + slack) * (1 + k_radius_inflation);
    // The square must not underflow to zero, or a primitive that touches the point would be culled.
    constexpr double k_smallest = 0x1p-60;
    return radius < std::numeric_limits<float>::max() ? round_up(std::max(radius, k_smallest))
                                                      : std::numeric_limits<float>::infinity();
}

}  // namespace tetrakis::detail
