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

/// The roots around one corner of a small mesh, as a level of a scheme: where its rows can be read off.
class CornerTemplate {
  public:
    /// @param like      in lattices or in cells, of as many sides
    /// @param segments  of a root's sides: a power of two
    /// @throws std::invalid_argument  as the scheme's step
    CornerTemplate(const CornerKind& kind, const RootLattices& like, std::uint32_t segments, const SchemeInfo& scheme,
                   const RuleOptions& rules);

    const CornerKind& kind() const { return kind_; }
    const RootLattices& net() const { return net_; }
    /// Half-edge of the net that leaves the corner along root i's first side.
    std::uint32_t halfedge(std::uint32_t root) const { return corner_[root]; }
    std::uint32_t segments() const { return segments_; }
    const RuleMesh& mesh() const { return mesh_; }
    /// The vertices of the mesh by place; empty: they are no such lattices.
    const std::vector<int>& numbers() const { return number_; }

    /// The vertices of the level after a step by place; nothing where it is no lattice.
    std::optional<std::vector<int>> finer_numbers(const RuleStep& step, std::uint32_t factor) const;

  private:
    void find_corner();
    std::vector<int> children(const RuleStep& step) const;

    CornerKind kind_;
    std::uint32_t segments_;
    RuleMesh mesh_;
    RootLattices net_;
    std::vector<std::uint32_t> corner_;
    std::vector<int> first_;  ///< as RootLattices::vertices() takes them
    std::vector<int> number_;
};

}  // namespace tetrakis::detail
