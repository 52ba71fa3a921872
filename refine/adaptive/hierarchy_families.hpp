#pragma once

#include "../../hier/trees/vertex_roots.hpp"
#include "hierarchy_family.hpp"

#include <memory>

namespace tetrakis {

/// The family of quad schemes: a 4-8 bisection forest over corner cells; see Hierarchy. Keeps a reference to the mesh.
/// @param source  points over corner cells: lattice level l is scheme level l + 1
std::unique_ptr<HierarchyFamily> bisection_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source);

/// The family of triangle schemes: triangle quadtrees with red-green closure; see Hierarchy.
/// @param source  points over face triangles: lattice level l is scheme level l
/// @throws Error  unsupported: a face is not a triangle
std::unique_ptr<HierarchyFamily> triangle_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source);

/// The family of dual schemes: vertex quadtrees; see Hierarchy. Keeps a reference to the mesh.
/// @param source  points over the cells of those roots, written as sites (cell_site())
std::unique_ptr<HierarchyFamily> vertex_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source,
                                               VertexRoots roots);

/// The family of the sqrt(3) scheme: triangles split at their centres and flipped; see Hierarchy. Keeps a reference to
/// the mesh.
/// @param source  points over sites as sqrt3_levels() gives them
/// @throws Error  as Sqrt3Forest
std::unique_ptr<HierarchyFamily> sqrt3_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source);
/// Levels that its paths have room for: 32, less on a mesh whose level 32 would have more than 2^64 half-edges.
int sqrt3_tree_levels(const ControlMesh& mesh);

}  // namespace tetrakis
