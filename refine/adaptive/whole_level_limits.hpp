#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/forest/vertex_roots.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "adaptive.hpp"
#include "level_source.hpp"

#include <memory>

namespace tetrakis::detail {

/// Limit positions of a scheme's sites from whole refined levels, wherever so many sites are asked for that this is
/// faster than to evaluate them by themselves; the others come from another source.
///
/// Structured refinement makes a vertex some hundred times faster than the rules evaluate a site. Levels that have been
/// made are kept. Those of schemes that keep their vertices answer for all sites of coarser levels, too. Positions
/// equal those of the other source to rounding error. Their last bits depend on what has been asked before, not on the
/// number of threads.
///
/// @param others   limit positions of single sites
/// @param roots    of dual schemes, whose sites are cells; null for others
/// @param context  its memory limit; levels that take more than a share of it are not made
/// Keeps references to the mesh and the scheme.
std::shared_ptr<const PositionSource> whole_level_limits(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                         const RuleOptions& rules,
                                                         std::shared_ptr<const LevelSource> others,
                                                         const VertexRoots* roots, const RunContext& context);

}  // namespace tetrakis::detail
