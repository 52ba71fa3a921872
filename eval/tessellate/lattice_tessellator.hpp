#pragma once

#include "tessellate.hpp"

namespace tetrakis::detail {

/// tessellate() by limit points for schemes whose vertices are sites of corner cells (4-8 bisection) or of face
/// triangles (red-green quadtrees).
Tessellation tessellate_on_lattice(const ControlMesh& mesh, const TessellateOptions& options,
                                   const RunContext& context);

}  // namespace tetrakis::detail
