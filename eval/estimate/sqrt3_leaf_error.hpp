#pragma once

#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <span>

namespace tetrakis::detail {

/// A leaf's error needs points of this many simple steps below its level, which the lattice must have.
inline constexpr int k_sqrt3_error_steps = 6;

/// Errors of triangles of sqrt(3) meshes: the largest distance of limit points to the leaf's triangle (PlaneMeasure),
/// on sharp edges to the triangle's own edge. The limit points are those that two more levels of the lattice have on
/// each side and inside.
/// @param points   gives the limit points
/// @param lattice  lattice of the leaves' forest
void sqrt3_leaf_errors(const Hierarchy& points, const Sqrt3Lattice& lattice, std::span<const Sqrt3Triangle> leaves,
                       std::span<double> errors);

}  // namespace tetrakis::detail
