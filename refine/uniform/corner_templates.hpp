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

/// Valence, tags and angles around a corner of a net's roots, which decide the stencil rows near it.
struct CornerKind {
    bool closed = true;       ///< whether the roots surround the corner; otherwise it is on a boundary
    float corner = 0;         ///< sharpness of the vertex
    bool crease_end = false;  ///< RootLattices::crease_ends()
    /// Sharpness of the sides that leave the corner, counter-clockwise: one side per root. If the roots do not close
    /// there is one side more, and the first and the last are infinitely sharp.
    std::vector<float> sharp;
    std::vector<double>
        angle{};  ///< corner angle of each root's sector (RuleMesh::corner_angle); empty: no sector has one

    std::uint32_t roots() const { return static_cast<std::uint32_t>(sharp.size()) - (closed ? 0 : 1); }
    bool sharp_before(std::uint32_t root) const { return is_sharp(sharp[root]); }
    bool sharp_after(std::uint32_t root) const { return is_sharp(sharp[(root + 1) % sharp.size()]); }
    /// Renumbers the roots: root 1 becomes root 0, and root 0 the last one.
    void turn();
    auto operator<=>(const CornerKind&) const = default;
};

/// The different kinds among the corners of a net.
struct CornerKinds {
    std::vector<CornerKind> kinds;
    std::vector<std::uint32_t> kind;  ///< for each half-edge of the base, the kind of its origin
    std::vector<std::uint32_t> root;  ///< for each half-edge of the base, the number of its root among the kind's roots
    /// Dependence of rows on sharpness: the rows of one step are the same for all values above 1, those of limits not.
    enum class Sees { one_step, all };
    /// @param mesh      the level whose tags count
    /// @param halfedge  for each half-edge of the net's base the half-edge of `mesh` at the same corner along the same
    ///                  side; empty: only boundaries are sharp
    /// @param angles    whether the scheme has rules for corner angles
    CornerKinds(const RootLattices& net, const RuleMesh& mesh, std::span<const int> halfedge, Sees sees, bool angles);
    bool operator==(const CornerKinds&) const = default;
};

/// A small refined mesh of the roots around one corner, from which the stencil rows near that corner are read off.
class CornerTemplate {
  public:
    /// @param like      a net of the same type: roots with as many sides, points on lattices or in cells
    /// @param segments  segments of a root's side; in cells a power of two
    /// @throws std::invalid_argument  as the scheme's step
    CornerTemplate(const CornerKind& kind, const RootLattices& like, std::uint32_t segments, const SchemeInfo& scheme,
                   const RuleOptions& rules);

    const CornerKind& kind() const { return kind_; }
    const RootLattices& net() const { return net_; }
    /// Half-edge of the net that leaves the corner along the first side of root `root`.
    std::uint32_t halfedge(std::uint32_t root) const { return corner_[root]; }
    std::uint32_t segments() const { return segments_; }
    const RuleMesh& mesh() const { return mesh_; }
    /// The vertex of mesh() at each place of the net; empty: the faces do not form the lattices.
    const std::vector<int>& numbers() const { return number_; }

    /// The vertex of the finer mesh at each of its places; empty if its faces do not form lattices.
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
