#pragma once

#include "../../hier/base/vec.hpp"
#include "../../schemes/analysis/mesh_part.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../../schemes/parts/sector_fan.hpp"
#include "../patches/cell.hpp"

#include <array>
#include <optional>
#include <vector>

namespace tetrakis::detail {

/// A face as a cell of a level's lattice: one of its corners, numbered counter-clockwise, and the half-edge that leaves
/// it.
struct CellFrame {
    int halfedge = RuleMesh::none;
    int corner = 0;
};

/// The half-edge of a face at another of its n corners.
inline int face_corner(const RuleMesh& mesh, const CellFrame& frame, int corner, int n) {
    int h = frame.halfedge;
    for (int c = frame.corner; c != corner; c = (c + 1) % n) h = mesh.next(h);
    return h;
}

/// One of four children of a cell with n corners. That at a corner has the same corner of its own there; the last of a
/// triangle is the middle one, whose corner k lies opposite corner k.
inline CellFrame child_cell(const RuleMesh& mesh, const RuleStep& step, const CellFrame& frame, int child, int n) {
    if (child < n) return {step.child_halfedge[face_corner(mesh, frame, child, n)], child};
    const int at_corner = step.child_halfedge[face_corner(mesh, frame, 0, n)];
    return {step.mesh.twin(step.mesh.next(at_corner)), 1};
}

/// The surroundings of a cell as numbers; cells with the same surroundings have the same numbers. A walk from the first
/// corner gives the faces: of each the vertices, numbered as the walk meets them, with whether the side that follows is
/// sharp. Then come the sharp vertices, and the angles of corners.
using SurroundingsKey = std::vector<int>;

struct CellSurroundings {
    SurroundingsKey key;
    std::vector<int> vertices;  ///< of the mesh, in the order in which the key numbers them; the cell's corners first
};

/// @param halfedge  leaves the cell's first corner
/// @param rings     of faces
/// @return  nothing where an edge or vertex is semi-sharp: tags differ around the same cell a level down
std::optional<CellSurroundings> cell_surroundings(const RuleMesh& mesh, int halfedge, int rings, MeshPartFinder& parts);

/// The surroundings of a cell at the middle of a fan.
SurroundingsKey fan_surroundings(FanLattice lattice, const FanShape& shape, int rings);

/// What one step of the rules makes of a cell with certain surroundings.
struct CellStep {
    std::vector<Vec2d> at;  ///< where a lattice that goes on from the cell has the points around it
    StencilTable rows;      ///< the next level's points, from these
    /// Those around its children, by rows.
    std::array<CellSurroundings, 4> children;
};

/// Largest number of edges at a vertex for which there are norms: the number of points around a cell, and of kinds of
/// surroundings, grows with it.
inline constexpr int k_most_edges = 64;

/// Nothing where the surroundings end in another way than a mesh does, or have a vertex of more than k_most_edges.
std::optional<CellStep> cell_step(const SchemeInfo& scheme, const RuleOptions& options, const SurroundingsKey& key,
                                  int cell_corners, int rings);

}  // namespace tetrakis::detail
