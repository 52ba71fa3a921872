#pragma once

#include "../core/rule_mesh.hpp"

#include <optional>
#include <vector>

namespace tetrakis::detail {

/// The vertices that the limit of a smooth vertex under honeycomb refinement depends on: itself, and per edge its
/// neighbour and six more. Empty where the mesh is not as every smooth vertex sees it after a few steps: hexagons
/// around it, neighbours with three edges, and hexagons beyond them.
std::optional<std::vector<int>> honeycomb_fan(const RuleMesh& mesh, int v);

/// Their weights, which sum to one: the left eigenvector of the fan's own subdivision matrix, by iteration of the
/// rules.
/// @param valence  >= 2
std::vector<double> honeycomb_limit_weights(int valence);

}  // namespace tetrakis::detail
