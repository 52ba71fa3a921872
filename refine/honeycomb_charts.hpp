#pragma once

#include "tetrakis/refine/followed_uvs.hpp"
#include "tetrakis/refine/hexagon_mesh.hpp"
#include "tetrakis/refine/seam_extension.hpp"

#include <span>

namespace tetrakis::detail {

/// What follow_across_seams() finds for honeycomb refinement, from level to level by arithmetic.
/// @param charts  extend_over_seams()
/// @param levels  from the control mesh to the last, which has been made for limits
FollowedUvs follow_hexagons(SeamExtension charts, std::span<const HexagonMesh> levels);

}  // namespace tetrakis::detail
