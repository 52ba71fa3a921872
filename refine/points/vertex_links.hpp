#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "level_walk.hpp"

#include <span>
#include <vector>

namespace tetrakis::detail {

/// The cells of a dual scheme's level 1, before their orientation is made that of corner cells: one for each vertex,
/// then for each vertex on creases those of its other sides. The half-edge of a cell lies at corner 2, and is the first
/// counter-clockwise of its side.
std::vector<CellFrame> vertex_frames(const RuleMesh& level);

/// The roots of a dual scheme's vertex quadtrees: the vertices of level 1, and how their cells lie beside each other.
/// @param level      level 1
/// @param frames     of its vertices' cells
/// @param root_face  of the cells that are children of corners: the control face; else invalid
/// @throws Error  unsupported: a vertex that does not have four children on each side of its creases
VertexRoots vertex_roots(const ControlMesh& control, const RuleMesh& level, std::span<const CellFrame> frames,
                         std::span<const FaceId> root_face);

}  // namespace tetrakis::detail
