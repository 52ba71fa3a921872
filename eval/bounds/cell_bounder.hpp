#pragma once

#include "../patches/loop_patches.hpp"
#include "../patches/quad_patches.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "patch_bounder.hpp"
#include "star_pieces.hpp"

#include <array>
#include <utility>
#include <vector>

namespace tetrakis {

/// Errors of leaves (of bisection forests, or of triangle quadtrees with their green closure) against the limit surface
/// of Catmull-Clark or Loop. One per thread; results depend on the leaf alone.
///
/// The error of a leaf with triangle T over the piece S of the surface is the largest of: the distance from a point of
/// S to T, and the distance from a point of S on a side of the leaf to that edge of T. It bounds the distance in both
/// directions. From S to T this is clear. From T to S: match each point of S over T's boundary with its foot on the
/// edge, and project S along T's normal. A point of T that lies on no segment between a foot and its projected point is
/// wound around once by the projected boundary, so S covers it, at a height within the error; a point on such a segment
/// is as near to the boundary of S as the foot is at most. Sliding along the surface costs nothing that way.
///
/// Both distances are convex functions of the point. On a regular cell the surface over a triangle is a polynomial of
/// degree 6 (Catmull-Clark) or 4 (Loop), so their largest values at its control points bound them; it is bisected until
/// these bounds decide. Cells at an extraordinary point are bounded by StarPieces; other irregular ones by the hull of
/// their control points, and quartered.
template <class Shape>
class CellBounder : private detail::PatchBounder {
  public:
    explicit CellBounder(const PatchTree<Shape>& patches);

    /// Bounds on the error of a leaf. They are refined until both lie on one side of `decide_at`, or are within a
    /// twentieth of each other. Where `lower` exceeds `decide_at`, `upper` may be infinite.
    /// @param sliding  of the leaf's edges (corner k to k + 1); with any, the error is the one defined at EdgeSliding
    /// @param may_reject  whether to stop, without an upper bound, once the error is certainly above `decide_at`
    LeafError leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding = {},
                         bool may_reject = true);

    /// Certified upper bound, tight to a twentieth where it exceeds `floor`. If `floor` is the largest bound so far,
    /// the largest over many leaves takes little more than one pass.
    double certified_error(const CellTriangle& leaf, double floor, const EdgeSliding& sliding = {}) {
        return leaf_error(leaf, floor, sliding, false).upper;
    }

    /// The same for any triangle in a root's parameters, with its corners on the surface. `upper` is never infinite.
    LeafError part_error(HalfedgeId root, const std::array<Vec2d, 3>& corners, double decide_at);

    /// The error of the depth-0 leaf of a quad's root against a triangle with another corner in place of the face's
    /// centre.
    LeafError root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject = true);

  private:
    using Node = typename PatchTree<Shape>::Node;
    using Corners = std::array<Vec2d, 3>;
    /// A triangle in a cell; its edge numbers are those of the leaf.
    using Piece = detail::LabelledTriangle;
    static constexpr int k_corners = Node::k_corners;

    /// @param at    corners, in a root; for quads also in the next corner's cell, where x is 1 to 2
    /// @param apex  third corner of the triangle, in place of the surface's point; or null
    LeafError error_over(HalfedgeId root, const Corners& at, const Vec3d* apex, const EdgeSliding& sliding);
    /// The surface's position; of points that neighbouring leaves share, from a cache.
    const Vec3d& position_at(HalfedgeId root, const Vec2d& p);
    /// The first regular cell, else the deepest, around a triangle. @param at  corners in the root, then in the cell
    const Node& locate(HalfedgeId root, Corners& at) const;
    void bound_cell(const Node& cell, const Piece& piece, int depth);
    /// @param at_corners  corner_error() of the piece
    void bound_irregular(const Node& cell, const Piece& piece, double at_corners, int depth);
    void bound_star(const Node& cell, const detail::StarPieces<Shape>& pieces, const Edges& edge, double at_corners,
                    int depth);
    void bound_regular(const Node& cell, const Piece& piece);
    /// @param strip  number of the piece (CreasePieces) that contains `piece`, for a crease of finite sharpness
    void bound_bicubic(const detail::QuadShape::Patch& cell, int strip, Piece piece);

    const PatchTree<Shape>& patches_;
    struct Known {
        HalfedgeId root{};
        Vec2d at{0};
        Vec3d position{0};
    };
    std::array<Known, 251> known_{};
};

using QuadBounder = CellBounder<detail::QuadShape>;
using LoopBounder = CellBounder<detail::LoopShape>;

}  // namespace tetrakis
