#pragma once

#include "tessellate.hpp"

namespace tetrakis::detail {

/// tessellate() by limit points for the sqrt(3) scheme: triangles are the leaves of a Sqrt3Forest. Levels in options
/// and result are those of refine(), two simple steps each.
Tessellation tessellate_sqrt3(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

}  // namespace tetrakis::detail
