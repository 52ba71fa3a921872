#pragma once

#include "../../hier/base/vec.hpp"
#include "cell_surroundings.hpp"

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A point as a combination of a cell's corners.
using CellAnchor = std::array<double, 4>;

/// Weights of the points around a cell, by how far each is from where the cell's corners would have it: their sum
/// bounds how far the limit is from the cell. With these points, and with no mesh, one can also go on to the cells of
/// the levels below.
struct CellNorms {
    struct Child {
        const CellNorms* norms = nullptr;
        StencilTable rows;  ///< its points, from those of the cell
    };

    std::vector<int> point;  ///< those that matter, by their numbers in the surroundings: the cell's corners first
    std::vector<double> weight;
    std::vector<CellAnchor> anchor;
    std::array<Child, 4> children;  ///< cells of the next level, by corner; a triangle's middle one is the last

    /// How far the limit is from a cell at most.
    /// @param points  those of `point`
    double remainder(std::span<const Vec3d> points) const;
};

/// A cell of a mesh, with the norms that all cells with the same surroundings share.
struct NormedCell {
    const CellNorms* norms = nullptr;  ///< nullptr: there are none, or a finer level is better asked
    int first = RuleMesh::none;        ///< half-edge that leaves the cell's first corner
    std::vector<int> points{};         ///< vertices of the mesh: those of norms->point
};

/// How far a limit surface may be from the mesh of a level over one of its cells (a triangle, or the bilinear patch of
/// a quad): the weights for each kind of surroundings, found when they are asked for.
///
/// "Where the corners would have it" is the affine or bilinear extension of the cell, where the rules around it
/// reproduce that (on a regular lattice, so the bound falls with the square of the cell), and else the first corner
/// (around an extraordinary point: it falls with the cell).
///
/// A weight is the largest size of the point's basis function on the vertices a few levels down, and what is left below
/// these: the same sum over each of the small cells there, whose points are combinations of those around the large one:
/// by the rows of the levels between, one after the other.
/// These equations between all kinds of surroundings that come up are solved by iteration, with a little room, and then
/// checked: no weight is below what the others make of it. That the iteration converges is the proof that the steps
/// contract (as in the difference schemes of Dyn, Levin, Gregory 1990; what surrounds the cell is in the place of the
/// regular lattice).
class CellNormTable {
  public:
    /// @param scheme   refines triangles or quads by face split
    /// @param options  must live as long
    CellNormTable(const SchemeInfo& scheme, const RuleOptions& options);

    /// Corners of a cell.
    int corners() const { return corners_; }
    /// Rings of faces around a cell that its norms depend on.
    int rings() const { return rings_; }

    /// nullptr where there are none. From any thread.
    const CellNorms* find(const SurroundingsKey& key) const;

    /// A cell of a mesh. On the first two levels norms are for cells alone that are regular and smooth all around: of
    /// the others nearly each has surroundings of its own, and a few cells two levels down cost far less than to find
    /// norms.
    /// @param mesh      of one level, with all that is within rings() + 1 rings of the cell
    /// @param halfedge  of the cell, always the same one for a face. The first corner is its origin, unless the
    ///                  surroundings decide on another
    /// @param parts     scratch memory
    NormedCell of_cell(const RuleMesh& mesh, int halfedge, int level, MeshPartFinder& parts) const;

    /// Of a cell at the middle of a fan: its bound is at most `sum` times the farthest point around it from where the
    /// corners would have it: in their plane (quads: their bilinear patch) or, where not `linear`, at the first corner.
    struct Total {
        double sum;
        bool linear;
    };
    /// Nothing where there is no bound.
    std::optional<Total> total(const FanShape& shape) const;

  private:
    class Search;

    const SchemeInfo& scheme_;
    const RuleOptions& options_;
    int corners_, rings_;
    mutable std::shared_mutex reading_;
    mutable std::mutex writing_;
    mutable std::map<SurroundingsKey, std::unique_ptr<const CellNorms>> known_;
};

}  // namespace tetrakis::detail
