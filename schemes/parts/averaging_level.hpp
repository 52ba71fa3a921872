#pragma once

#include "../core/rule_step.hpp"

#include <array>
#include <functional>
#include <vector>

namespace tetrakis::detail {

/// One level of repeated averaging without its points: which of them there are, of what each is the
/// mean, and the mesh that is made of them at the end.
///
/// The points are first those of the bilinear split, at the vertices of split(). Averaging 0, 2, ... makes one for each
/// quad of split(), averaging 1, 3, ... one for each vertex again.
class AveragingLevel {
  public:
    /// @throws std::invalid_argument  options.averaging_steps < 0
    AveragingLevel(const RuleMesh& mesh, const RuleOptions& options);

    int averagings() const { return averagings_; }
    /// Two averagings, which take Catmull-Clark's rules at boundaries, creases and corners; the others have none
    /// inside.
    bool has_sharp_rules() const { return sharp_rules_; }
    /// The mesh of the level before; without sharp edges inside if there are no rules for them.
    const RuleMesh& mesh() const { return mesh_; }
    /// The mesh, with copies of its boundary around it where they are needed, split: the quad of each half-edge.
    const RuleMesh& split() const { return split_; }
    /// Where the split puts a vertex: at a vertex of mesh(), in the middle of an edge (numbers after the vertices) or
    /// of a face (after the edges). Copies are where their originals are.
    int place(int v) const { return place_[v]; }
    /// The vertex of split() at a place, and not a copy of it.
    int vertex_at(int place) const;
    bool is_copy(int v) const { return vertex_at(place_[v]) != v; }
    bool is_quad_of_copies(int q) const { return q >= mesh_.halfedge_count(); }

    /// The vertices that have points before the first averaging.
    std::vector<char> made() const;
    /// The quads or vertices to which an averaging gives points, from those that had points before it.
    std::vector<char> made(int averaging, const std::vector<char>& before) const;
    /// Whose mean the point of a quad or (closed) vertex is.
    ShortList<int, 8> around(int averaging, int point) const;

    struct End {
        RuleStep step;
        std::vector<int> centre;  ///< of each face: the vertex (odd number of averagings) or quad in its middle
    };
    /// The next level's mesh.
    /// @param made  by the last averaging
    /// @param row   of the point of a quad or vertex; called by many threads at once
    /// @throws std::invalid_argument  nothing of the mesh is left
    End end(const std::vector<char>& made, const BlockRunner* runner, const std::function<StencilRow(int)>& row) const;

  private:
    End replicated_dual(const BlockRunner* runner, const std::function<StencilRow(int)>& row) const;
    End receding(const std::vector<char>& made, const std::function<StencilRow(int)>& row) const;

    int averagings_;
    bool sharp_rules_, recedes_;
    RuleMesh mesh_, split_;
    int layered_vertices_ = 0, layered_edges_ = 0;  ///< with copies
    std::vector<int> place_;
    std::vector<std::array<int, 2>> outer_;  ///< of a boundary half-edge: the copies' quads at its origin and target
    std::vector<int> tip_;                   ///< of a tagged corner: its quad of copies
};

}  // namespace tetrakis::detail
