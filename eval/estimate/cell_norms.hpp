#pragma once

#include "../../hier/base/vec.hpp"
#include "cell_surroundings.hpp"

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Weights of a cell's corners whose combination is an expected point.
using CellAnchor = std::array<double, 4>;

/// Weights that bound the distance from a cell to its limit. An anchor extends the cell to an expected position of each
/// point around it; the bound is the weighted sum of the points' distances from these. The same points give the cells
/// of the next levels, without a mesh.
struct CellNorms {
    struct Child {
        const CellNorms* norms = nullptr;
        StencilTable rows;  ///< rows that compute its points from those of the cell
    };

    std::vector<int> point;  ///< the points used, by their numbers in the surroundings: the cell's corners first
    std::vector<double> weight;
    std::vector<CellAnchor> anchor;
    std::array<Child, 4> children;  ///< cells of the next level, by corner; the middle one of a triangle is the last

    /// Upper bound on the distance from a cell to its limit.
    /// @param points  positions of the points in `point`
    double remainder(std::span<const Vec3d> points) const;
};

/// A cell of a mesh, with the norms that all cells with the same surroundings share.
struct NormedCell {
    const CellNorms* norms = nullptr;  ///< nullptr: there are none, or not on this level: use a finer one
    int first = RuleMesh::none;        ///< half-edge that leaves the cell's first corner
    std::vector<int> points{};         ///< mesh vertices of the points in norms->point; without norms, the corners
};

/// Bounds on the distance from a cell of a level's mesh (a triangle, or the bilinear patch of a quad) to its limit. It
/// holds the weights for each kind of surroundings, computed on first use.
///
/// Expected positions are the affine or bilinear extension of the cell if the rules around it reproduce that, as on a
/// regular lattice: then the bound falls with the square of the cell's size. Else, around an extraordinary point, they
/// are the first corner, and the bound falls with the size itself.
///
/// A weight has two parts. The first is the largest absolute value, on the vertices a few levels down, of the point's
/// basis function (for corners, less their hat function). The second is the largest remainder over the small cells
/// there. Their points are combinations of those around the large cell, by the rows of the levels between, so it is a
/// sum of the small cells' weights. These equations between all kinds of surroundings are solved by iteration, with a
/// little room. A check follows that no weight is below its equation. Convergence proves that the steps contract (as in
/// the difference schemes of Dyn, Levin, Gregory 1990, with the cell's surroundings in place of the regular lattice).
class CellNormTable {
  public:
    /// @param scheme   a scheme that refines triangles or quads by face split
    /// @param options  must outlive the table, like `scheme`
    CellNormTable(const SchemeInfo& scheme, const RuleOptions& options);

    /// Number of corners of a cell.
    int corners() const { return corners_; }
    /// Number of rings of faces around a cell on which its norms depend.
    int rings() const { return rings_; }

    /// Norms of cells with these surroundings; nullptr if there are none. Thread-safe.
    const CellNorms* find(const SurroundingsKey& key) const;

    /// Norms of a cell of a mesh. On the first two levels there are norms only for regular and smooth surroundings.
    /// Others are nearly all different there, and computing their norms costs far more than going two levels down.
    /// @param mesh      mesh of one level, with all faces within rings() + 1 rings of the cell
    /// @param halfedge  half-edge of the cell, always the same one for a face. Its origin is the first corner, unless
    ///                  there are norms from another corner only
    /// @param parts     scratch memory
    NormedCell of_cell(const RuleMesh& mesh, int halfedge, int level, MeshPartFinder& parts) const;

    /// Bound of a cell at the middle of a fan: at most `sum` times the largest distance of a point around it from its
    /// expected position. This is in the corners' plane (quads: bilinear patch) or, if not `linear`, at the first
    /// corner.
    struct Total {
        double sum;
        bool linear;
    };
    /// Empty if there is no bound.
    std::optional<Total> total(const FanShape& shape) const;

  private:
    class Search;

    const SchemeInfo& scheme_;
    const RuleOptions& options_;
    int corners_, rings_;
    mutable std::mutex mutex_;
    mutable std::map<SurroundingsKey, std::unique_ptr<const CellNorms>> known_;
};

}  // namespace tetrakis::detail
