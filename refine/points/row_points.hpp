#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "level_source.hpp"

#include <memory>

namespace tetrakis::detail {

/// The points of any scheme at any of its sites by the rows of weights that its rules repeat from level to level
/// (RepeatedRows): of each level above a site only the vertices that its rows lead to, up to the last level that the
/// rules have to make whole. That takes less than a microsecond a site and level, where the rules take up to a hundred.
///
/// Points equal those of the other source to rounding error. The other source answers where rows do not repeat
/// (RepeatedRows::make), on levels coarser than the first, and where the first level or what it takes to learn the rows
/// is too large. The first call makes that level and learns the rows: up to some seconds on a cage of 100,000 faces.
///
/// @param others        the same scheme's
/// @param roots         of dual schemes, whose sites are cells; null for others
/// @param context       its memory limit; a first level that takes more than a share of it is not made
/// @param whole_levels  waits with the first level until enough sites have been asked for, and makes further levels
///                      whole where many are: faster, and the last bits then depend on the calls before
/// Keeps references to the mesh and the scheme.
std::shared_ptr<const LevelSource> row_points(const ControlMesh& mesh, const SchemeInfo& scheme,
                                              const RuleOptions& rules, std::shared_ptr<const LevelSource> others,
                                              const VertexRoots* roots, const RunContext& context, bool whole_levels);

}  // namespace tetrakis::detail
