#pragma once

#include "../rules/vertex_ring.hpp"
#include "grid_refinement.hpp"

namespace tetrakis::detail {

/// Limit positions and unit normals of the last level's vertices; either may be null.
/// @param points  control points of the last level, three scalars each; k_limit_padding more may be read past their end
template <class T>
void grid_limits(const GridTopology& topology, const T* points, T* positions, T* normals, const RunContext& context,
                 KernelSet set = best_kernels());

}  // namespace tetrakis::detail
