#pragma once

#include "../patches/loop_patches.hpp"
#include "../patches/quad_patches.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "patch_bounder.hpp"

#include <array>
#include <utility>
#include <vector>

namespace tetrakis {

/// Errors of leaves (of bisection forests, or of triangle quadtrees with their green closure) against the limit surface
/// of Catmull-Clark or Loop. One per thread; results depend on the leaf alone.
///
/// The error of a leaf with triangle T over the piece S of the surface is the largest of: the distance from a point of
/// S to T, and the distance from a point of S on a side of the leaf to that edge of T. It bounds the distance in both
/// directions. From S to T that is plain. From T to S: match each point of S over T's boundary with its foot on the
/// edge, and project S along T's normal. A point of T that lies on no segment between a foot and its projected point is
/// wound around once by the projected boundary, so S covers it, at a height within the error; a point on such a segment
/// is as near to the boundary of S as the foot is at most. Sliding along the surface costs nothing that way.
///
/// Both distances are convex functions of the point. On a regular cell the surface over a triangle is a polynomial of
/// degree 6 (Catmull-Clark) or 4 (Loop), so the largest over its control points bounds them; it is bisected until that
/// decides. Irregular cells are quartered towards the extraordinary point: stars are bounded by norms, other cells by
/// the hull of their control points.
template <class Shape>
class CellBounder : private detail::PatchBounder {
  public:
    explicit CellBounder(const PatchTree<Shape>& patches);

    /// The error of a leaf, or bounds on it: refined until they lie on one side of `decide_at` or within a twentieth;
    /// where `lower` exceeds `decide_at`, `upper` may be infinite.
    /// @param sliding  of the leaf's edges (corner k to k + 1): where there is some, the error is that of EdgeSliding
    /// @param may_reject  ends as soon as the error is certainly above `decide_at`, which then has no upper bound
    LeafError leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding = {},
                         bool may_reject = true);

    /// Certified bound, tight to a twentieth where it exceeds `floor`: the largest over many leaves takes little more
    /// than one pass.
    double certified_error(const CellTriangle& leaf, double floor, const EdgeSliding& sliding = {}) {
        return leaf_error(leaf, floor, sliding, false).upper;
    }

    /// The same of any triangle of a root's parameters, with its corners on the surface. It is not rejected.
    LeafError part_error(HalfedgeId root, const std::array<Vec2d, 3>& corners, double decide_at);

    /// The error of the depth-0 leaf of a quad's root against a triangle with another corner in place of the face's
    /// centre.
    LeafError root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject = true);

  private:
    using Node = typename PatchTree<Shape>::Node;
    using Corners = std::array<Vec2d, 3>;
    /// A triangle in a cell; edges are the leaf's.
    using Piece = detail::LabelledTriangle;
    static constexpr int k_corners = Node::k_corners;

    /// @param at    in a root; of quads also in the next corner's cell, from (1, 0) to (2, 1)
    /// @param apex  of the triangle in place of the surface's, or null
    LeafError error_over(HalfedgeId root, const Corners& at, const Vec3d* apex, const EdgeSliding& sliding);
    /// The cell that a triangle lies in, as far down as it is irregular. @param at  its corners in the root, then in it
    const Node& locate(HalfedgeId root, Corners& at) const;
    void bound_cell(const Node& cell, const Piece& piece, int depth);
    /// @param is_leaf  the piece is all of the leaf
    void bound_regular(const Node& cell, const Piece& piece, bool is_leaf);
    /// @param strip  of a cell with a crease of finite sharpness: the piece of the curve across it that `piece` is in
    void bound_bicubic(const detail::QuadShape::Patch& cell, int strip, Piece piece, bool is_leaf);
    const detail::SexticWeights& weights_over(const Corners& at);

    /// Bound on the error over a piece of an irregular cell: by norms, else by the hull of its points.
    /// @param may_split  as hull_error() has it
    double irregular_error(const Node& cell, const Piece& piece, bool may_split) const;
    /// Bound on the error, over a piece, of the linear or bilinear function with a cell's corners.
    double corner_error_in(const Node& cell, const Piece& piece) const;

    const PatchTree<Shape>& patches_;
    std::vector<std::pair<Corners, detail::SexticWeights>> weights_{};  ///< by triangles they are for
};

using QuadBounder = CellBounder<detail::QuadShape>;
using LoopBounder = CellBounder<detail::LoopShape>;

}  // namespace tetrakis
