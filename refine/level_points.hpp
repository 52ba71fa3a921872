#pragma once

#include "tetrakis/hier/vec.hpp"
#include "tetrakis/refine/mesh_level.hpp"
#include "tetrakis/refine/vertex_ring.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// How points pass from a level to the next.
enum class PointRule {
    scheme,  ///< the scheme's masks with all tags
    linear,  ///< old points stay, new ones are means of their edge or face (linear UVs)
};

/// Points of the next level, in its vertex order (see MeshLevel); gathers only, so every thread count gives the same.
/// @param points   level.vertex_count points
/// @param finer    finer.vertex_count points, to be written
void refine_points(const MeshLevel& level, SchemeKind scheme, CreaseMethod method, PointRule rule,
                   std::span<const Vec3d> points, std::span<Vec3d> finer);

/// The ring of vertex v with its tags, for limit_point(). Catmull-Clark: on a level of quads.
void gather_ring(const MeshLevel& level, SchemeKind scheme, CreaseMethod method, std::span<const Vec3d> points,
                 std::uint32_t v, VertexRing& ring);

/// Limit position, and normal if asked, of an interior vertex without tags, straight from the arrays; false where
/// limit_point() has to look at it (tags, boundary, isolated, no tangent plane).
bool smooth_limit(const MeshLevel& level, SchemeKind scheme, std::span<const Vec3d> points, std::uint32_t v,
                  Vec3d& position, Vec3d* normal);

}  // namespace tetrakis::detail
