#pragma once

#include "../../hier/base/vec.hpp"
#include "cell_norms.hpp"

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// All cells with the same surroundings, of whatever level: how far the limit is from them, and what the rules make of
/// the points around them. Once a cell's kind is known, it goes down level by level without a mesh.
struct CellKind {
    struct Child {
        const CellKind* kind = nullptr;
        StencilTable rows;  ///< the points around the child, from those around the cell
    };
    using Children = std::array<Child, 4>;

    const SurroundingsKey* key = nullptr;
    const CellNorms* norms = nullptr;  ///< nullptr: the limit may be anywhere

    mutable std::once_flag once{};
    mutable Children children{};  ///< see CellKinds::children()
};

/// The kinds of cells of a scheme, by mask norms: the limit surface is as near to the mesh of a level over one of its
/// cells (a triangle, or the bilinear patch of a quad) as the sum over the points around the cell of how far each is
/// from where the cell's own corners would have it, times a weight (CellNormTable).
///
/// "Where the corners would have it" is the affine or bilinear extension of the cell, where the rules around it
/// reproduce that (on a regular lattice, so the bound falls with the square of the cell), and else the first corner
/// (around an extraordinary point: it falls with the cell).
class CellKinds {
  public:
    /// @param scheme   refines triangles or quads by face split
    /// @param options  must live as long
    CellKinds(const SchemeInfo& scheme, const RuleOptions& options);

    /// Corners of a cell.
    int corners() const { return corners_; }
    /// Rings of faces around a cell that its kind depends on.
    int rings() const { return rings_; }

    /// Of a cell at the middle of a fan: its bound is at most `sum` times the farthest point around it from where the
    /// corners would have it: in their plane (quads: their bilinear patch) or, where not `linear`, at the first corner.
    struct Total {
        double sum;
        bool linear;
    };
    /// Nothing where there is no bound.
    std::optional<Total> total(const FanShape& shape) const;

    /// From any thread.
    const CellKind& find(const SurroundingsKey& key) const;
    /// The four cells that one step makes of a cell of this kind, which has norms or comes from one that has. From any
    /// thread.
    const CellKind::Children& children(const CellKind& kind) const;
    /// How far the limit is from a cell at most.
    /// @param points  around the cell, as its kind numbers them: its corners first
    double remainder(const CellKind& kind, std::span<const Vec3d> points) const;

  private:
    const SchemeInfo& scheme_;
    const RuleOptions& options_;
    int corners_, rings_;
    CellNormTable table_;
    mutable std::shared_mutex mutex_;
    mutable std::map<SurroundingsKey, std::unique_ptr<CellKind>> kinds_;
};

/// Finds the cells of a mesh that have norms, for one thread.
class CellKindFinder {
  public:
    /// @param mesh   of one level, with all that is within rings() + 1 rings of the cells that are asked for
    /// @param parts  scratch memory
    CellKindFinder(const CellKinds& kinds, const RuleMesh& mesh, MeshPartFinder& parts);

    struct Found {
        const CellKind* kind =
            nullptr;                ///< nullptr: more than one extraordinary point is near, or something semi-sharp
        int turns = 0;              ///< the first corner's number among the face's, from the half-edge
        std::vector<int> vertices;  ///< of the mesh, around the cell
    };
    /// @param halfedge  of the cell
    Found operator()(int halfedge) const;

  private:
    const CellKinds& kinds_;
    const RuleMesh& mesh_;
    MeshPartFinder& parts_;
    std::vector<int> near_;  ///< per vertex: the one extraordinary point near it, k_none or k_many
};

}  // namespace tetrakis::detail
