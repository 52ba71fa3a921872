#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "level_source.hpp"
#include "position_source.hpp"

#include <memory>

namespace tetrakis::detail {

/// A frame from a position, an area-weighted sum of normals and a direction `towards` a neighbour. If `towards` is
/// parallel to the normal, the tangents have any direction orthogonal to it.
LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards);

/// Points of any scheme at any of its sites, by stencil rows that repeat from level to level (RepeatedRows). The rules
/// make the first levels whole. On later levels only the vertices that a site needs are computed, in less than a
/// microsecond per site and level.
///
/// Whole levels by the rules (WholeLevels) give the points of the first levels, and all points where rows do not
/// repeat: with semi-sharp creases of Chaikin's method, around vertices without a limit mask, and if the first level is
/// too large. The first call makes the first level and learns the rows: up to some seconds for 100,000 control faces.
///
/// @param roots         for dual schemes, whose sites are cells; null for others
/// @param context       only its memory limit is used
/// @param whole_levels  also computes later levels whole where calls ask for many of their sites: faster, but the last
///                      bits then depend on earlier calls
/// @param limit_positions  unless null, gives limit_positions(); limits() does not use it
/// Keeps references to the mesh and the scheme.
/// @throws Error  invalid_input: a mesh that the scheme cannot take
std::shared_ptr<const LevelSource> row_points(const ControlMesh& mesh, const SchemeInfo& scheme,
                                              const RuleOptions& rules, const VertexRoots* roots,
                                              const RunContext& context, bool whole_levels,
                                              std::shared_ptr<const PositionSource> limit_positions = {});

}  // namespace tetrakis::detail

namespace tetrakis {

/// Points of the sqrt(3) scheme at sites of control triangles (sqrt3_site()). A level is one simple step; refine()
/// counts two of them as a level. Even levels and limits come from detail::row_points(); an odd level comes by one
/// simple step from the even level before it. Keeps references to the mesh and the scheme.
/// @param mesh  of triangles
/// @param context, whole_levels, limit_positions  as in row_points()
std::shared_ptr<const LevelSource> sqrt3_levels(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                const RuleOptions& rules, const RunContext& context, bool whole_levels,
                                                std::shared_ptr<const PositionSource> limit_positions = {});

}  // namespace tetrakis
