#pragma once

#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/mesh_level.hpp"

#include <span>

namespace tetrakis::detail {

/// How points pass from a level to the next.
enum class PointRule {
    scheme,  ///< the scheme's masks with all tags
    linear,  ///< old points stay, new ones are means of their edge or face (linear UVs)
};

/// Points of the first refinement into quads by Catmull-Clark, in its vertex order (see refine_to_quads()); gathers
/// only, so every thread count gives the same.
/// @param points   level.vertex_count points
/// @param finer    finer.vertex_count points, to be written
void refine_points(const MeshLevel& level, CreaseMethod method, PointRule rule, std::span<const Vec3d> points,
                   std::span<Vec3d> finer);

}  // namespace tetrakis::detail
