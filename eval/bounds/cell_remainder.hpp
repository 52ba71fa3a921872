#pragma once

#include "../../hier/base/vec.hpp"
#include "../../refine/adaptive/level_walk.hpp"
#include "cell_norms.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// How far a limit surface may be from the mesh of a level over one of its cells (a triangle, or the bilinear patch of
/// a quad), by mask norms: the sum over the points around the cell of how far each is from where the cell's own corners
/// would have it, times a weight (CellNormTable).
///
/// "Where the corners would have it" is the affine or bilinear extension of the cell, where the rules around it
/// reproduce that (on a regular lattice, so the bound falls with the square of the cell), and else the first corner
/// (around an extraordinary point: it falls with the cell).
class CellRemainder {
  public:
    /// @param scheme   refines triangles or quads by face split
    /// @param options  must live as long
    CellRemainder(const SchemeInfo& scheme, const RuleOptions& options);

    /// Corners of a cell.
    int corners() const { return corners_; }
    /// Rings of faces around a cell that its bound depends on.
    int rings() const { return rings_; }

    /// Of a cell at the middle of a fan: its bound is at most `sum` times the farthest point around it from where the
    /// corners would have it: in their plane (quads: their bilinear patch) or, where not `linear`, at the first corner.
    struct Total {
        double sum;
        bool linear;
    };
    /// Nothing where there is no bound.
    std::optional<Total> total(const FanShape& shape) const;

    /// One level's mesh, for one thread.
    class Level {
      public:
        /// The mesh has all that is within rings() + 1 rings of the cells that are asked for.
        Level(const CellRemainder& remainder, const RuleMesh& mesh, std::span<const Vec3d> points,
              MeshPartFinder& parts);
        /// Of a cell, by the half-edge that leaves its first corner; infinite where nothing is known: more than one
        /// extraordinary point is near, or something is semi-sharp.
        double operator()(int halfedge);

      private:
        void find_irregular();
        double sum(const CellNorms& norms, int halfedge, std::span<const int> points) const;

        const CellRemainder& remainder_;
        const RuleMesh& mesh_;
        std::span<const Vec3d> points_;
        MeshPartFinder& parts_;
        std::vector<std::uint8_t> irregular_;  ///< within rings() - 1 rings of such a vertex
        std::vector<int> entry_, found_;
    };

  private:
    /// A walk over half-edges to the regular lattice's points: face k is entered across the edge `turns` after the
    /// half-edge by which face `from` was.
    struct Walk {
        struct Face {
            int from, turns;
        };
        struct Point {
            int face, turns;
        };
        std::vector<Face> faces;
        std::vector<Point> points;
    };
    Walk walk_to(const SurroundingsKey& key, std::span<const int> points) const;
    FanLattice lattice() const { return corners_ == 3 ? FanLattice::triangles : FanLattice::quads; }

    int corners_, rings_;
    CellNormTable table_;
    const CellNorms* regular_ = nullptr;
    Walk regular_walk_;
};

}  // namespace tetrakis::detail
