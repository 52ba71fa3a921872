#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/vertex_roots.hpp"
#include "tetrakis/refine/level_walk.hpp"

#include <span>

namespace tetrakis::detail {

/// The roots of a dual scheme's vertex quadtrees: the vertices of level 1, and how their cells lie beside each other.
/// @param level      level 1
/// @param frames     of its vertices' cells
/// @param root_face  of the vertices that are children of corners: the control face; else invalid
/// @throws Error  unsupported: a vertex that does not have four children
VertexRoots vertex_roots(const ControlMesh& control, const RuleMesh& level, std::span<const CellFrame> frames,
                         std::span<const FaceId> root_face);

}  // namespace tetrakis::detail
