#pragma once

#include "tessellate.hpp"

#include <string>

/// tessellate() for surfaces that are known by limit points alone.
namespace tetrakis::detail {

/// @throws Error  as tessellate(), with options that have been checked for what all schemes have in common
Tessellation tessellate_by_limits(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by limit points for schemes whose vertices are sites of corner cells (4-8 bisection) or of face
/// triangles (red-green quadtrees).
Tessellation tessellate_on_lattice(const ControlMesh& mesh, const TessellateOptions& options,
                                   const RunContext& context);

/// tessellate() by limit points for dual schemes: vertices are the leaves of vertex quadtrees.
Tessellation tessellate_dual(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by limit points for the sqrt(3) scheme: triangles are the leaves of a Sqrt3Forest. Levels in options
/// and result are those of refine(), two simple steps each.
Tessellation tessellate_sqrt3(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);

/// tessellate() by whole levels, for schemes that no hierarchy has (honeycomb): the first level of refine() that is
/// within the tolerance, its faces cut into triangles.
Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context);
/// The same with a warning, for meshes that a scheme's hierarchy cannot take.
/// @throws Error  unsupported: the certified estimator
Tessellation tessellate_by_levels(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context,
                                  const std::string& why_not_adaptive);

}  // namespace tetrakis::detail
