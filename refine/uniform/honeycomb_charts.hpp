#pragma once

#include "../attributes/followed_uvs.hpp"
#include "../attributes/seam_extension.hpp"
#include "hexagon_mesh.hpp"

#include <span>

namespace tetrakis::detail {

/// What follow_across_seams() finds for honeycomb refinement, from level to level by arithmetic.
/// @param charts  extend_over_seams()
/// @param levels  from the control mesh to the last, which has been made for limits
FollowedUvs follow_hexagons(SeamExtension charts, std::span<const HexagonMesh> levels);

}  // namespace tetrakis::detail
