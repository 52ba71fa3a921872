#pragma once

#include "../surface/box_spline.hpp"

namespace tetrakis::detail {

/// Weights of a regular triangle's 12 points for the positions of a barycentric lattice: what box_spline_weights()
/// would compute anew for each of the few points that samples stand on.
class BoxSplineLattice {
  public:
    /// Intervals a side: lattices of 4 on a patch, its quarters, and their quarters.
    static constexpr int k_side = 16;

    /// Position at a point of the patch.
    static Vec3d position(const Net12& net, const Bary& at);

  private:
    BoxSplineLattice();
    static int number(int i, int j) { return i * (k_side + 1) + j; }
    std::array<std::array<double, 12>, (k_side + 1) * (k_side + 1)> weights_;
};

}  // namespace tetrakis::detail
