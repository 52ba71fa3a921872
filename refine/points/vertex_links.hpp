#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../../schemes/core/scheme_table.hpp"

namespace tetrakis {

/// The roots of a dual scheme's vertex quadtrees: the vertices of level 1, and the adjacency of their cells. O(H).
/// @throws Error  invalid_input: a mesh that the scheme cannot take, a scheme that is not dual; unsupported: a vertex
///                that does not have four children on each side of its creases, a boundary that recedes
VertexRoots vertex_roots(const ControlMesh& control, const SchemeInfo& scheme, const RuleOptions& rules = {});

/// The cells of level 1 as the faces of a mesh: root r is face r, and its corner 0 the first one of the face. Positions
/// are zero. Cells on both sides of a crease share vertices; at the boundary they reach beyond the surface.
ControlMeshData cell_mesh(const VertexRoots& roots);

}  // namespace tetrakis
