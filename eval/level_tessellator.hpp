#pragma once

#include "tetrakis/eval/tessellate.hpp"

namespace tetrakis::detail {

/// tessellate() by whole levels, for schemes that no hierarchy has (honeycomb): the first level of refine() that is
/// within the tolerance, its faces cut into triangles.
Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

}  // namespace tetrakis::detail
