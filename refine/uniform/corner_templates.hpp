#pragma once

#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../lattices/root_lattices.hpp"

#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// What lies around a corner of a net's roots and decides the rows of weights near it.
struct CornerKind {
    bool closed = true;
    float corner = 0;         ///< how sharp the vertex is
    bool crease_end = false;  ///< RootLattices::crease_ends()
    /// How sharp the sides that leave it are, counter-clockwise: one per root, and one more where the roots do not
    /// close, whose ends are sharp for ever.
    std::vector<float> sharp;
    std::vector<double>
        angle{};  ///< of a corner's sectors, for each root (RuleMesh::corner_angle); empty: none has one

    std::uint32_t roots() const { return static_cast<std::uint32_t>(sharp.size()) - (closed ? 0 : 1); }
    bool sharp_before(std::uint32_t root) const { return is_sharp(sharp[root]); }
    bool sharp_after(std::uint32_t root) const { return is_sharp(sharp[(root + 1) % sharp.size()]); }
    /// The same from its next root on.
    void turn();
    auto operator<=>(const CornerKind&) const = default;
};

/// The kinds of a net's corners, each of them once.
struct CornerKinds {
    std::vector<CornerKind> kinds;
    std::vector<std::uint32_t> kind;  ///< of each half-edge of the base: that of its origin
    std::vector<std::uint32_t> root;  ///< which of the kind's roots the half-edge's is
    /// What a level's rows can see of its tags: those of a step no more of a sharpness than whether it outlasts that.
    enum class Sees { one_step, all };
    /// @param mesh      a level
    /// @param halfedge  of it, for each one of the base the one at the same corner along the same side; empty: nothing
    ///                  is sharp but what is open
    /// @param angles    whether the scheme has rules for corners' angles
    CornerKinds(const RootLattices& net, const RuleMesh& mesh, std::span<const int> halfedge, Sees sees, bool angles);
    bool operator==(const CornerKinds&) const = default;
};

/// The roots around one corner, by themselves, as a level of a scheme: where its rows can be read off.
class CornerTemplate {
  public:
    /// @param sides     of a root: 4 or 3
    /// @param in_cells  as RootLattices
    /// @param segments  of a root's sides
    CornerTemplate(const CornerKind& kind, std::uint32_t sides, bool in_cells, std::uint32_t segments);

    const CornerKind& kind() const { return kind_; }
    const RootLattices& net() const { return net_; }
    /// Half-edge of the net that leaves the corner along root i's first side.
    std::uint32_t halfedge(std::uint32_t root) const { return net_.side_count() * root; }
    std::uint32_t segments() const { return segments_; }
    /// Its vertices have the numbers of the places.
    const RuleMesh& mesh() const { return mesh_; }
    /// The place that a point has its number from.
    std::uint32_t first_place(std::uint32_t place) const { return first_of(net_.layout(segments_), place); }
    /// The other place of a point that has two, or this one.
    std::uint32_t other_place(std::uint32_t place) const;

    struct Step {
        StencilTable rows;
        std::vector<int> row;  ///< of each place of the finer level; -1 far from the corner, where none is known
    };
    /// Nothing where the finer level is no lattice.
    /// @throws std::invalid_argument  as the scheme's step
    std::optional<Step> step(const SchemeInfo& scheme, const RuleOptions& rules, std::uint32_t factor) const;

  private:
    void make_lattice();
    void make_cells();
    std::uint32_t first_of(const RootLayout& at, std::uint32_t place) const;
    std::optional<std::vector<int>> rows_of_cells(const RuleMesh& finer) const;
    std::vector<int> rows_of_crease_end(const RuleStep& step) const;

    CornerKind kind_;
    std::uint32_t segments_;
    RootLattices net_;
    RuleMesh mesh_;
    /// Of the net's half-edges the one of the mesh at the same corner, along the same side. In lattices.
    std::vector<int> first_;
    /// In cells: the place of the child of each half-edge of the mesh.
    std::vector<std::uint32_t> child_place_;
};

}  // namespace tetrakis::detail
