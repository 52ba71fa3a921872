#pragma once

#include "../base/run_context.hpp"
#include "control_mesh.hpp"

namespace tetrakis {

/// Cuts every face of more than three corners into triangles, for schemes that need them (Loop).
///
/// Rule: ears are cut one after the other, always the one with the shortest diagonal; for a quadrilateral this is its
/// shorter diagonal (to 12 bits). Ears that face backwards, hold a reflex corner or leave a backward triangle come
/// last; ties go to the lower corner. A diagonal never repeats an edge of the mesh or another diagonal (as would happen
/// at vertices of valence 2); where that leaves no ear, the rest of the face becomes a fan around a new vertex at its
/// mean. Texture coordinates, normals, materials, groups, holes, lines and tags are kept, diagonals are smooth, and
/// vertices that BoundaryRule::edge_and_corner made sharp stay so (as corner tags). A warning says how many faces were
/// cut.
/// @throws Error memory_limit, cancelled
/// Cost: O(H log H), for concave faces times their reflex corners.
ControlMesh triangulate(const ControlMesh& mesh, const RunContext& context = {});

}  // namespace tetrakis
