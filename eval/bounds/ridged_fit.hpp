#pragma once

#include "dual_patch.hpp"

#include <array>
#include <span>

namespace tetrakis::detail {

/// Least squares over the points that a DualPatch of four pieces is found from: 1, s, s^2, t, s t, t^2, and the squares
/// of t - s and s + t - 1 where these are positive, which are all functions that are quadratic on each of the four
/// triangles of a square and smooth across its diagonals.
class RidgedFit {
  public:
    static constexpr std::size_t k_terms = 8;
    /// Per term what each point's value counts.
    using Rows = std::array<std::array<double, DualPatch::k_points>, k_terms>;

    /// @param s, t  of the columns and rows: middles of quarters, the outermost also 0 and 1
    static const Rows& of(std::span<const double> s, std::span<const double> t);
};

}  // namespace tetrakis::detail
