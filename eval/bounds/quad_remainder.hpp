#pragma once

#include "../surface/cell_facts.hpp"

#include <limits>

namespace tetrakis::detail {

/// Rounding of one patch evaluation and one interpolation, in units of the largest coordinate: fewer than 100
/// operations on values not larger than it, each off by half an ulp at most.
inline constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

/// A function minus the quadratic through its values at the corners and edge middles of a triangle is at most
/// xxx |f_xxx| + xxy |f_xxy| + ...: from Taylor's formula with the remainder, (1 / 6) sum_j |l_j(p)| |a_j - p|^3 with
/// the basis l_j of the nodes a_j, maximised over p for each kind of piece in the parameters of its cell.
inline constexpr ThirdBounds k_half_remainder{0.0207, 0.0445, 0.0445, 0.0207};
inline constexpr ThirdBounds k_quarter_remainder{0.0148, 0.0119, 0.0083, 0.0026};  // base along x

/// The same on a line of length 1: max |t (t - 1/2) (t - 1)| / 6 = sqrt(3) / 216.
inline constexpr double k_line_remainder = 0.00802;

inline double remainder_of(const ThirdBounds& third, int turn, bool quarter) {
    const ThirdBounds& k = quarter ? k_quarter_remainder : k_half_remainder;
    if ((turn & 1) == 0) return k.xxx * third.xxx + k.xxy * third.xxy + k.xyy * third.xyy + k.yyy * third.yyy;
    return k.xxx * third.yyy + k.xxy * third.xyy + k.xyy * third.xxy + k.yyy * third.xxx;
}

}  // namespace tetrakis::detail
