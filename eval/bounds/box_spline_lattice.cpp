#include "box_spline_lattice.hpp"

namespace tetrakis::detail {

BoxSplineLattice::BoxSplineLattice() {
    constexpr double step = 1.0 / k_side;
    for (int i = 0; i <= k_side; ++i)
        for (int j = 0; i + j <= k_side; ++j)
            weights_[static_cast<std::size_t>(number(i, j))] =
                box_spline_weights({i * step, j * step, (k_side - i - j) * step});
}

Vec3d BoxSplineLattice::position(const Net12& net, const Bary& at) {
    static const BoxSplineLattice lattice;
    const double x = at[0] * k_side, y = at[1] * k_side;
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    if (i != x || j != y) return box_spline_position(net, at);
    const std::array<double, 12>& weights = lattice.weights_[static_cast<std::size_t>(number(i, j))];
    Vec3d sum = weights[0] * net[0];
    for (std::size_t k = 1; k < 12; ++k) sum += weights[k] * net[k];
    return sum;
}

}  // namespace tetrakis::detail
