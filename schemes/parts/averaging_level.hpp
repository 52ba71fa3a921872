#pragma once

#include "../core/rule_step.hpp"

#include <array>
#include <functional>
#include <vector>

namespace tetrakis::detail {

/// One level of repeated averaging without the values of its points: which points there are, which points each of them
/// is the mean of, and the next level's mesh.
///
/// At first the points are those of the bilinear split, at the vertices of split(). Averagings 0, 2, ... make a point
/// for each quad of split(), averagings 1, 3, ... one for each vertex.
class AveragingLevel {
  public:
    /// @throws std::invalid_argument  options.averaging_steps is not in 0 .. k_most_averaging_steps
    AveragingLevel(const RuleMesh& mesh, const RuleOptions& options);

    int averagings() const { return averagings_; }
    /// Whether boundaries, creases and corners have Catmull-Clark's rules: with two averagings and replicated boundary.
    /// Other levels have no rules for sharp edges inside.
    bool has_sharp_rules() const { return sharp_rules_; }
    /// The coarser mesh; without sharp edges inside if there are no rules for them.
    const RuleMesh& mesh() const { return mesh_; }
    /// The bilinear split of the mesh and of the copies of its boundary around it, if any: one quad per half-edge.
    const RuleMesh& split() const { return split_; }
    /// The element of mesh() in whose middle vertex `v` of split() is: a vertex, an edge (numbered after the vertices)
    /// or a face (numbered after the edges). A copy has the same element as its original.
    int place(int v) const { return place_[v]; }
    /// The vertex of split() in the middle of an element, which is not a copy.
    int vertex_at(int place) const;
    bool is_copy(int v) const { return vertex_at(place_[v]) != v; }
    bool is_quad_of_copies(int q) const { return q >= mesh_.halfedge_count(); }

    /// Per vertex of split(), whether it has a point before the first averaging.
    std::vector<char> made() const;
    /// Per quad or vertex, whether an averaging gives it a point; `before` says the same of the averaging before it.
    std::vector<char> made(int averaging, const std::vector<char>& before) const;
    /// The vertices or quads whose mean is the point of a quad or (interior) vertex.
    ShortList<int, 8> around(int averaging, int point) const;

    struct End {
        RuleStep step;
        std::vector<int> centre;  ///< per face: the vertex (odd number of averagings) or quad in its middle
    };
    /// The next level's mesh.
    /// @param made  result of made() for the last averaging
    /// @param row   gives the row of a quad's or vertex' point; called by many threads at once
    /// @throws std::invalid_argument  nothing of the mesh is left
    End end(const std::vector<char>& made, const BlockRunner* runner, const std::function<StencilRow(int)>& row) const;

  private:
    End replicated_dual(const BlockRunner* runner, const std::function<StencilRow(int)>& row) const;
    End receding(const std::vector<char>& made, const std::function<StencilRow(int)>& row) const;

    int averagings_;
    bool sharp_rules_, recedes_;
    RuleMesh mesh_, split_;
    int layered_vertices_ = 0, layered_edges_ = 0;  ///< counts, with copies
    std::vector<int> place_;
    std::vector<std::array<int, 2>> outer_;  ///< per boundary half-edge: the copies' quads at its origin and target
    std::vector<int> tip_;                   ///< per tagged corner: its quad of copies
};

}  // namespace tetrakis::detail
