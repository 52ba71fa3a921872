#pragma once

#include "../forest/site.hpp"
#include "../mesh/control_mesh.hpp"

namespace tetrakis {

// Side s of a triangle root runs from corner s to corner s + 1 (mod 3), along the half-edge `root + s`: side 0 is y =
// 0, side 1 is x + y = 2^level, side 2 is x = 0.

/// The canonical site of a point of a triangle mesh: of all addresses that of minimal level; on a control edge in the
/// face with the smaller number, at a control vertex in that of ControlMesh::vertex_halfedge(). Hole faces count as
/// roots: the surface is defined over them too. O(1).
/// @param site  any address, with x + y <= 2^level
Site canonical_triangle_site(const ControlMesh& mesh, const Site& site);
/// That of a control vertex; the root is invalid for an isolated one.
Site triangle_vertex_site(const ControlMesh& mesh, VertexId v);

}  // namespace tetrakis
