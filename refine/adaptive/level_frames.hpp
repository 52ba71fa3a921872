#pragma once

#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../rules/vertex_ring.hpp"

#include <functional>
#include <span>

namespace tetrakis::detail {

class QuadStencils;
class TriangleStencils;

/// Gives the positions of sites at the level that is looked at.
using SitePositions = std::function<void(std::span<const Site>, std::span<Vec3d>)>;

/// LevelSource::frames() on a lattice level of the quad or triangle family. O(ring) positions a site.
void lattice_frames(const ControlMesh& mesh, const QuadStencils& rings, std::span<const Site> sites, int lattice_level,
                    const SitePositions& positions, std::span<LimitPoint> out);
void lattice_frames(const ControlMesh& mesh, const TriangleStencils& rings, std::span<const Site> sites,
                    int lattice_level, const SitePositions& positions, std::span<LimitPoint> out);
/// The same of the control mesh at its vertices.
LimitPoint control_frame(const ControlMesh& mesh, VertexId v);

/// A frame from a position, a sum of normals by area and a direction from the position to a neighbour.
LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards);

}  // namespace tetrakis::detail
