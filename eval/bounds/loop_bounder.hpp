#pragma once

#include "../patches/bezier_triangle.hpp"
#include "../patches/loop_patches.hpp"
#include "labelled_polygon.hpp"
#include "patch_bounder.hpp"

#include <array>

namespace tetrakis {

/// Errors of leaves of triangle quadtrees (red triangles, and the halves and quarters of their green closure) against a
/// Loop limit surface. One per thread; results depend on the leaf alone.
///
/// The error of a leaf with triangle T over the piece S of the surface is QuadBounder's: the largest of the distance
/// from a point of S to T, and the distance from a point of S on a side of the leaf to that edge of T. It bounds the
/// distance in both directions. Regular cells are polynomials of degree 4; irregular ones are quartered towards the
/// extraordinary point: stars are bounded by norms, other cells by the hull of their control points.
class LoopBounder : private detail::PatchBounder<> {
  public:
    explicit LoopBounder(const LoopPatches& patches);

    /// Bounds on the error of a leaf, refined until they lie on one side of `decide_at` or within a twentieth; where
    /// `lower` exceeds `decide_at`, `upper` may be infinite.
    /// @param sliding  at edges where there is some, the error is that of EdgeSliding
    /// @param may_reject  ends as soon as the error is certainly above `decide_at`
    LeafError leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding = {},
                         bool may_reject = true);

    /// The same of any triangle of a root's parameters, with its corners on the surface. It is not rejected.
    LeafError part_error(HalfedgeId root, const std::array<Vec2d, 3>& corners, double decide_at);

    /// As QuadBounder has it.
    double certified_error(const CellTriangle& leaf, double floor, const EdgeSliding& sliding = {}) {
        return leaf_error(leaf, floor, sliding, false).upper;
    }

  private:
    using Corners = std::array<detail::Bary, 3>;
    /// A triangle within a cell; edges are the leaf's.
    using Piece = detail::LabelledTriangle<detail::Bary>;

    /// @param at  a triangle in the root
    LeafError error_over(HalfedgeId root, const Corners& at, const EdgeSliding& sliding);
    /// The cell that a triangle lies in, as far down as it is irregular. @param at  its corners in the root, then in it
    const detail::LoopNode& locate(HalfedgeId root, Corners& at) const;
    void bound_cell(const detail::LoopNode& cell, const Piece& piece, int depth);
    /// Bound on the error of a piece of an irregular cell: a star's by norms, any other's by its hull.
    /// @param may_split  as hull_error() has it
    double irregular_error(const detail::LoopNode& cell, const Piece& piece, bool may_split) const;
    /// corner_error() where the surface's corners, and the function linear between them, are the cell's.
    double corner_error_in(const detail::LoopNode& cell, const Piece& piece) const;

    const LoopPatches& patches_;
};

}  // namespace tetrakis
