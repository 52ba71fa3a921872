#pragma once

#include "../../refine/rules/mesh_part.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/sector_fan.hpp"

#include <optional>
#include <vector>

namespace tetrakis::detail {

/// What is around a cell, as numbers that are the same for all cells that have the same around them: face by face in
/// the order of a walk from the cell's first corner, their vertices as the walk meets them, and what is sharp.
using SurroundingsKey = std::vector<int>;

struct CellSurroundings {
    SurroundingsKey key;
    std::vector<int> vertices;  ///< of the mesh, in the order in which the key numbers them; the cell's corners first
};

/// @param halfedge  leaves the cell's first corner
/// @param rings     of faces
/// @return  nothing where an edge or vertex is semi-sharp: what is around the same cell a level down is then another
std::optional<CellSurroundings> cell_surroundings(const RuleMesh& mesh, int halfedge, int rings, MeshPartFinder& parts);

/// The surroundings of a cell at the middle of a fan.
SurroundingsKey fan_surroundings(FanLattice lattice, const FanShape& shape, int rings);

/// A mesh of these surroundings. Half-edge 0 leaves the cell's first corner.
/// @throws std::invalid_argument  it ends in another way than a mesh does
RuleMesh surroundings_mesh(const SurroundingsKey& key);

/// Whether a vertex has the lattice's own number of edges; on a crease or boundary, on each side.
bool is_regular_vertex(const RuleMesh& mesh, int vertex, int cell_corners);

/// Whether the mesh has cells alone, and no more than one extraordinary point within `rings` - 1 rings of face 0: those
/// whose own faces are all there.
bool is_simple(const RuleMesh& mesh, int cell_corners, int rings);

}  // namespace tetrakis::detail
