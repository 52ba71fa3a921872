#pragma once

#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <span>

namespace tetrakis::detail {

/// Steps below a leaf's level whose points its error looks at: the lattice must have as many more.
inline constexpr int k_sqrt3_error_steps = 6;

/// Errors of triangles of sqrt(3) meshes: per leaf the largest distance of points of the limit surface to the triangle
/// as PlaneMeasure takes it, along sharp edges to its own edge. The points are those that two more levels of the
/// lattice have on each side and inside.
/// @param points   gives the limit points
/// @param lattice  of the leaves' forest
void sqrt3_leaf_errors(const Hierarchy& points, const Sqrt3Lattice& lattice, std::span<const Sqrt3Triangle> leaves,
                       std::span<double> errors);

}  // namespace tetrakis::detail
