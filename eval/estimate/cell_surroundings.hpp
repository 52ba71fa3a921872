#pragma once

#include "../../hier/base/vec.hpp"
#include "../../schemes/analysis/mesh_part.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../patches/cell.hpp"

#include <array>
#include <optional>
#include <vector>

namespace tetrakis::detail {

/// A face as a cell of a level's lattice: the number of one of its corners, counter-clockwise, and the half-edge that
/// leaves this corner.
struct CellFrame {
    int halfedge = RuleMesh::none;
    int corner = 0;
};

/// The half-edge that leaves corner `corner` of a face with n corners.
inline int face_corner(const RuleMesh& mesh, const CellFrame& frame, int corner, int n) {
    int h = frame.halfedge;
    for (int c = frame.corner; c != corner; c = (c + 1) % n) h = mesh.next(h);
    return h;
}

/// One of the four children of a cell with n corners. The child at corner k has its own corner k there. The last child
/// of a triangle is the middle one; its corner k lies opposite corner k.
inline CellFrame child_cell(const RuleMesh& mesh, const RuleStep& step, const CellFrame& frame, int child, int n) {
    if (child < n) return {step.child_halfedge[face_corner(mesh, frame, child, n)], child};
    const int at_corner = step.child_halfedge[face_corner(mesh, frame, 0, n)];
    return {step.mesh.twin(step.mesh.next(at_corner)), 1};
}

/// The surroundings of a cell as a list of numbers, the same for cells with the same surroundings. Faces come first, in
/// breadth-first order from the first corner. Each lists its vertices, numbered in order of first visit, and whether
/// the edge after each is sharp. Then come the sharp vertices, and the angles of corners.
using SurroundingsKey = std::vector<int>;

struct CellSurroundings {
    SurroundingsKey key;
    std::vector<int> vertices;  ///< mesh vertices, in the order of their numbers in the key; the cell's corners first
};

/// @param halfedge  half-edge that leaves the cell's first corner
/// @param rings     number of rings of faces
/// @return  empty if an edge or vertex is semi-sharp (the next level's tags differ), or faces are not joined by edges
std::optional<CellSurroundings> cell_surroundings(const RuleMesh& mesh, int halfedge, int rings, MeshPartFinder& parts);

/// Result of one step of the rules for a cell with given surroundings.
struct CellStep {
    std::vector<Vec2d> at;  ///< lattice coordinates of the points around the cell, which is the unit cell
    StencilTable rows;      ///< rows that compute the next level's points from these
    /// Surroundings of its children; their vertices are numbers of rows.
    std::array<CellSurroundings, 4> children;
};

/// Largest number of edges at a vertex for which there are norms: points around a cell, and kinds of surroundings,
/// become more with it.
inline constexpr int k_most_edges = 64;

/// Empty if the surroundings are no valid mesh at their border, or if a vertex has more than k_most_edges edges.
std::optional<CellStep> cell_step(const SchemeInfo& scheme, const RuleOptions& options, const SurroundingsKey& key,
                                  int cell_corners, int rings);

}  // namespace tetrakis::detail
