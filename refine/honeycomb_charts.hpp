#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/refine/followed_uvs.hpp"
#include "tetrakis/refine/hexagon_mesh.hpp"
#include "tetrakis/schemes/scheme_table.hpp"

#include <span>

namespace tetrakis::detail {

/// What follow_across_seams() finds for honeycomb refinement, from level to level by arithmetic.
/// @param levels  from the control mesh to the last, which has been made for limits
FollowedUvs follow_hexagons(const ControlMesh& mesh, const SchemeInfo& scheme, const RuleOptions& rules,
                            std::span<const HexagonMesh> levels);

}  // namespace tetrakis::detail
