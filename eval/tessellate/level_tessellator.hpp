#pragma once

#include "tessellate.hpp"

#include <string>

namespace tetrakis::detail {

/// tessellate() by whole levels, for schemes that no hierarchy has (honeycomb): the first level of refine() that is
/// within the tolerance, its faces cut into triangles.
Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);
/// The same with a warning, for meshes that a scheme's hierarchy cannot take.
/// @throws Error  unsupported: the certified estimator
Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                                  const std::string& why_not_adaptive);

}  // namespace tetrakis::detail
