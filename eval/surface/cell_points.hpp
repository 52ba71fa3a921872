#pragma once

#include "bicubic.hpp"

#include <array>

namespace tetrakis::detail {

/// Limit positions of a cell at (column / 2, row / 2), number 3 * row + column: corners, middles of the sides, centre.
using CellPoints = std::array<Vec3d, 9>;

/// Those of a smooth regular cell.
CellPoints cell_points(const Net16& net);

}  // namespace tetrakis::detail
