#pragma once

#include "../../refine/rules/mesh_part.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../../schemes/parts/sector_fan.hpp"

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
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

/// Quads in four: the child at a corner has the same corner of its own there.
inline CellFrame quad_child(const RuleMesh& mesh, const RuleStep& step, const CellFrame& frame, int child) {
    return {step.child_halfedge[face_corner(mesh, frame, child, 4)], child};
}

/// Triangles in four: children at the corners, then the middle one, whose corner k lies opposite corner k.
inline CellFrame triangle_child(const RuleMesh& mesh, const RuleStep& step, const CellFrame& frame, int child) {
    if (child < 3) return {step.child_halfedge[face_corner(mesh, frame, child, 3)], child};
    const int at_corner = step.child_halfedge[face_corner(mesh, frame, 0, 3)];
    return {step.mesh.twin(step.mesh.next(at_corner)), 1};
}

/// What is around a cell, as numbers that are the same for all cells that have the same around them: face by face in
/// the order of a walk from the cell's first corner, their vertices as the walk meets them, and what is sharp.
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

/// A mesh of these surroundings. Half-edge 0 leaves the cell's first corner.
/// @throws std::invalid_argument  it ends in another way than a mesh does
RuleMesh surroundings_mesh(const SurroundingsKey& key);

/// Whether a vertex has the lattice's own number of edges; on a crease or boundary, on each side.
bool is_regular_vertex(const RuleMesh& mesh, int vertex, int cell_corners);

/// Weights and sums of rounding errors alone.
inline constexpr double k_no_weight = 1e-11;

/// A combination of points, each at most once: its number and its weight.
using SparseRow = std::vector<std::pair<int, double>>;

/// Sums sparse rows, with scratch memory.
class SparseSum {
  public:
    explicit SparseSum(int points) : value_(points, 0.0), seen_(points, 0) {}
    void add(int point, double weight) {
        if (!std::exchange(seen_[point], 1)) touched_.push_back(point);
        value_[point] += weight;
    }
    void add(const SparseRow& row, double factor) {
        for (const auto& [point, weight] : row) add(point, factor * weight);
    }
    /// Returns the sum and clears it.
    SparseRow take();

  private:
    std::vector<double> value_;
    std::vector<char> seen_;
    std::vector<int> touched_;
};

/// A point as a combination of a cell's corners.
using CellAnchor = std::array<double, 4>;

/// What some levels of the rules make of a cell with certain surroundings: the points around the small cells that it
/// becomes, as combinations of those around it.
struct CellDescent {
    struct Child {
        SurroundingsKey key;
        std::vector<int> vertices;  ///< of `rows`, as the key numbers them
    };

    std::vector<SparseRow> rows;
    std::vector<Child> children;
};

/// What a cell's norms are found from: the same of a few levels, and of one.
struct CellEquations {
    CellDescent below;               ///< of a few levels
    CellDescent next;                ///< of one: the cells at the corners; a triangle's middle one is the last
    int points = 0;                  ///< around the cell, its corners first
    std::vector<CellAnchor> anchor;  ///< where the corners would have each of these
    std::vector<double> direct;      ///< size of each one's basis function, less the hats of the corners
    std::vector<int> active;         ///< those that matter

    /// The first corner for all.
    std::vector<CellAnchor> constant() const { return std::vector<CellAnchor>(points, {1, 0, 0, 0}); }
    /// Whether a point may be anywhere else than where the corners would have it.
    bool is_free(int i) const {
        for (int k = 0; k < 4; ++k)
            if (anchor[i][k] != (k == i ? 1.0 : 0.0)) return true;
        return false;
    }
    /// Whether a combination of the points is 0 where all are where the corners would have them.
    bool annihilates(const SparseRow& functional) const;
};

/// Largest number of edges at a vertex for which there are weights: the number of points and of equations grows with
/// it.
inline constexpr int k_most_edges = 64;

/// Nothing where the surroundings are no mesh of cells alone, or have a vertex of more than k_most_edges edges. With
/// several extraordinary points they would be as many as there are cells, and of no further use.
std::optional<CellEquations> cell_equations(const SchemeInfo& scheme, const RuleOptions& options,
                                            const SurroundingsKey& key, int cell_corners, int rings);

}  // namespace tetrakis::detail
