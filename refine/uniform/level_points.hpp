#pragma once

#include "../../hier/base/vec.hpp"
#include "mesh_level.hpp"

#include <span>

namespace tetrakis::detail {

/// How points pass from a level to the next.
enum class PointRule {
    scheme,  ///< the scheme's masks with all tags
    linear,  ///< old points stay, new ones are means of their edge or face (linear UVs)
};

/// Where the points of a refinement into quads go: those of the level's vertices, faces and edges.
struct QuadPoints {
    std::span<Vec3d> old, faces, edges;
    QuadPoints(std::span<Vec3d> of_old, std::span<Vec3d> of_faces, std::span<Vec3d> of_edges)
        : old(of_old), faces(of_faces), edges(of_edges) {}
    /// In the vertex order of refine_to_quads().
    QuadPoints(const MeshLevel& level, std::span<Vec3d> finer)
        : old(finer.first(level.vertex_count)),
          faces(finer.subspan(level.vertex_count, level.face_count)),
          edges(finer.subspan(std::size_t{level.vertex_count} + level.face_count, level.edge_count)) {}
};

/// Points of the first refinement into quads by Catmull-Clark; gathers only, so every thread count gives the same.
/// @param points   level.vertex_count points
void refine_points(const MeshLevel& level, CreaseMethod method, PointRule rule, std::span<const Vec3d> points,
                   const QuadPoints& finer);

}  // namespace tetrakis::detail
