#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "level_source.hpp"
#include "position_source.hpp"

#include <memory>

namespace tetrakis::detail {

/// A frame from a position, a sum of normals by area and a direction from the position to a neighbour; any direction
/// across the normal where that one is along it.
LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards);

/// The points of any scheme at any of its sites by the rows of weights that its rules repeat from level to level
/// (RepeatedRows): of each level above a site only the vertices that its rows lead to, up to the last level that the
/// rules have to make whole. That takes less than a microsecond a site and level.
///
/// Whole levels by the rules (WholeLevels) answer for the first levels, and where rows do not repeat: with semi-sharp
/// creases of Chaikin's method, around vertices without a limit mask, and on cages whose first level is too large. The
/// first call makes the first level and learns the rows: up to some seconds on a cage of 100,000 faces.
///
/// @param roots         of dual schemes, whose sites are cells; null for others
/// @param context       its memory limit
/// @param whole_levels  makes further levels whole where many sites are: faster, and the last bits then depend on the
///                      calls before
/// @param limit_positions  limit positions from elsewhere, unless null; limits() gives those by rules all the same
/// Keeps references to the mesh and the scheme.
/// @throws Error  invalid_input: a mesh that the scheme cannot take
std::shared_ptr<const LevelSource> row_points(const ControlMesh& mesh, const SchemeInfo& scheme,
                                              const RuleOptions& rules, const VertexRoots* roots,
                                              const RunContext& context, bool whole_levels,
                                              std::shared_ptr<const PositionSource> limit_positions = {});

}  // namespace tetrakis::detail

namespace tetrakis {

/// The sqrt(3) scheme's points over sites of control triangles (sqrt3_site()). Levels are simple steps, two of which
/// are one level of refine(). Even levels and limits are those of detail::row_points(), odd levels are one simple step
/// from the even ones. Keeps references to the mesh and the scheme.
/// @param mesh  of triangles
/// @param context, whole_levels, limit_positions  as row_points() takes them
std::shared_ptr<const LevelSource> sqrt3_levels(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                const RuleOptions& rules, const RunContext& context, bool whole_levels,
                                                std::shared_ptr<const PositionSource> limit_positions = {});

}  // namespace tetrakis
