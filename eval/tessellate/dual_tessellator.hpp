#pragma once

#include "tessellate.hpp"

namespace tetrakis::detail {

/// tessellate() by limit points for dual schemes: vertices are the leaves of vertex quadtrees.
Tessellation tessellate_dual(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

}  // namespace tetrakis::detail
