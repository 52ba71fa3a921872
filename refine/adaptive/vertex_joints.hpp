#pragma once

#include "../../hier/forest/vertex_roots.hpp"
#include "../../schemes/core/rule_mesh.hpp"

#include <cstdint>
#include <span>

namespace tetrakis::detail {

/// Finds where semi-sharp creases and corners turn smooth, and how the vertices there are split: fills smooth_from and
/// the joints of roots that were made as if they never did.
/// @param level  level 1
/// @param cut    the same with all that is sharp there, or was above it, sharp for ever: where the roots are cut
/// @param place  per half-edge of the level 4 * root + corner
void add_joints(VertexRoots& roots, const RuleMesh& level, const RuleMesh& cut, std::span<const std::uint32_t> place);

}  // namespace tetrakis::detail
