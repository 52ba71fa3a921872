#pragma once

#include "../base/run_context.hpp"
#include "control_mesh.hpp"

namespace tetrakis {

/// Cuts every face of more than three corners into triangles, for schemes that need triangles (Loop).
///
/// Rule: ears are cut one after the other, always the one with the shortest diagonal; for a quadrilateral this is its
/// shorter diagonal (compared to 12 bits). Ears that face backward, contain a reflex corner or leave a backward
/// triangle come last; on ties the lower corner is first. A diagonal never repeats an edge of the mesh or another
/// diagonal, as might happen at vertices of valence 2. If no ear is left then, the rest of the face becomes a fan
/// around a new vertex at its mean. Texture coordinates, normals, materials, groups, holes, lines and tags are kept.
/// Diagonals are smooth; vertices that BoundaryRule::edge_and_corner made sharp get corner tags. A warning gives the
/// number of faces that were cut.
/// @throws Error memory_limit, cancelled
/// Cost: O(H log H); for concave faces, times their reflex corners.
ControlMesh triangulate(const ControlMesh& mesh, const RunContext& context = {});

}  // namespace tetrakis
