#pragma once

#include "../surface/bicubic.hpp"

namespace tetrakis::detail {

/// Sixteenths of a cell: every lattice of a piece stands on them.
constexpr int k_lattice_parts = 16;

/// B-spline weights at sixteenths.
const Weights4& part_weights(int part);

/// Positions of a piece's lattice points in sixteenths of its cell: origin + i a + j b towards its corners 1 and 2. A
/// piece is half a cell (right angle at corner `turn`; corners turn, turn + 1, turn + 3) or a quarter of it (corners:
/// the centre, turn, turn + 1).
struct LatticeShape {
    int ox, oy, ax, ay, bx, by, step;

    LatticeShape(int turn, bool quarter, int n);
    int x(int i, int j) const { return ox + i * ax + j * bx; }
    int y(int i, int j) const { return oy + i * ay + j * by; }
};

/// A smooth net evaluated along x at the columns of a lattice: four control points along y are left for each.
class LatticeColumns {
  public:
    LatticeColumns(const Net16& net, const LatticeShape& shape);
    Vec3d at(int x, int y) const;

  private:
    double rows_[k_lattice_parts + 1][3][4];
};

}  // namespace tetrakis::detail
