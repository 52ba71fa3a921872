#pragma once

#include "tessellate.hpp"

/// tessellate() for surfaces that are known by limit points alone.
namespace tetrakis::detail {

/// @throws Error  as tessellate(), with options that have been checked for what all schemes have in common
Tessellation tessellate_by_limits(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

}  // namespace tetrakis::detail
