#include "quad_lattice.hpp"

namespace tetrakis::detail {

namespace {

struct PartWeights {
    Weights4 at[k_lattice_parts + 1];
    PartWeights() {
        for (int i = 0; i <= k_lattice_parts; ++i) at[i] = cubic_basis(static_cast<double>(i) / k_lattice_parts);
    }
};
const PartWeights k_part_weights;

constexpr int corner_x(int k) { return ((k & 3) == 1 || (k & 3) == 2) ? k_lattice_parts : 0; }
constexpr int corner_y(int k) { return (k & 3) >= 2 ? k_lattice_parts : 0; }

}  // namespace

const Weights4& part_weights(int part) { return k_part_weights.at[part]; }

LatticeShape::LatticeShape(int turn, bool quarter, int n) {
    const int first = quarter ? turn : turn + 1, second = quarter ? turn + 1 : turn + 3;
    ox = quarter ? k_lattice_parts / 2 : corner_x(turn), oy = quarter ? k_lattice_parts / 2 : corner_y(turn);
    step = k_lattice_parts / (quarter ? 2 * n : n);
    ax = (corner_x(first) - ox) / n, ay = (corner_y(first) - oy) / n;
    bx = (corner_x(second) - ox) / n, by = (corner_y(second) - oy) / n;
}

LatticeColumns::LatticeColumns(const Net16& net, const LatticeShape& shape) {
    for (int i = 0; i <= k_lattice_parts; i += shape.step) {
        const Weights4& w = k_part_weights.at[i];
        for (int k = 0; k < 3; ++k)
            for (int r = 0; r < 4; ++r) {
                const double* p = net.c[k] + 4 * r;
                rows_[i][k][r] = (w[0] * p[0] + w[1] * p[1]) + (w[2] * p[2] + w[3] * p[3]);
            }
    }
}

Vec3d LatticeColumns::at(int x, int y) const {
    const Weights4& w = k_part_weights.at[y];
    Vec3d result;
    for (int k = 0; k < 3; ++k) {
        const double* p = rows_[x][k];
        result[k] = (w[0] * p[0] + w[1] * p[1]) + (w[2] * p[2] + w[3] * p[3]);
    }
    return result;
}

}  // namespace tetrakis::detail
