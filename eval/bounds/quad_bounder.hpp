#pragma once

#include "../patches/quad_patches.hpp"
#include "bezier_pieces.hpp"
#include "labelled_polygon.hpp"
#include "patch_bounder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace tetrakis {

/// Errors of bisection leaves against the limit surface of Catmull-Clark. One per thread; results depend on the leaf
/// alone.
///
/// The error of a leaf with triangle T over the piece S of the surface is the largest of: the distance from a point of
/// S to T, and the distance from a point of S on a side of the leaf to that edge of T. It bounds the distance in both
/// directions. From S to T that is plain. From T to S: match each point of S over T's boundary with its foot on the
/// edge, and project S along T's normal. A point of T that lies on no segment between a foot and its projected point is
/// wound around once by the projected boundary, so S covers it, at a height within the error; a point on such a segment
/// is as near to the boundary of S as the foot is at most. Sliding along the surface costs nothing that way.
///
/// Both distances are convex functions of the point. On a regular cell the surface over a triangle is a polynomial of
/// degree 6, so the largest over its control points bounds them; it is bisected until that decides. Irregular cells are
/// quartered towards the extraordinary point: stars are bounded by norms, other cells by the hull of their control
/// points.
class QuadBounder : private detail::PatchBounder<> {
  public:
    explicit QuadBounder(const QuadPatches& patches);

    /// The error of a leaf, or bounds on it: refined until they lie on one side of `decide_at` or within a twentieth.
    /// @param sliding  of the leaf's edges (corner k to k + 1): where there is some, the error is that of EdgeSliding
    /// @param may_reject  ends as soon as the error is certainly above `decide_at`, which then has no upper bound
    LeafError leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSliding& sliding = {},
                         bool may_reject = true);

    /// Certified bound, tight to a twentieth where it exceeds `floor`: the largest over many leaves takes little more
    /// than one pass.
    double certified_error(const CellTriangle& leaf, double floor, const EdgeSliding& sliding = {}) {
        return leaf_error(leaf, floor, sliding, false).upper;
    }

    /// The error of the depth-0 leaf of a root against a triangle with another corner in place of the face's centre.
    LeafError root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject = true);

  private:
    using Corners = std::array<Vec2d, 3>;
    /// A triangle in a cell, in lengths of its sides; edges are the leaf's.
    using Piece = detail::LabelledTriangle<Vec2d>;
    /// A cell of any level.
    struct Cell {
        std::uint32_t x = 0, y = 0;
        const detail::QuadNode* irregular = nullptr;  ///< null: it is one patch
        detail::QuadShape::Patch patch;

        Vec3d position(const Vec2d& at) const {
            return irregular ? QuadPatches::position(*irregular, at) : detail::QuadShape::position(patch, at);
        }
    };

    /// The cell that a leaf of one cell is half or a quarter of. @param at  receives the leaf's corners in it
    const Cell& locate(const CellTriangle& leaf, Corners& at);
    void push_cell(const detail::QuadNode& node, std::uint32_t x, std::uint32_t y);
    void bound_root(HalfedgeId root, const Vec3d* centre, const EdgeSliding& sliding);
    void bound_cell(const detail::QuadNode& cell, const Piece& piece, int depth);
    void bound_regular(const detail::QuadShape::Patch& cell, Piece piece);
    /// A cell with a crease of finite sharpness is strips along the crease, each one bicubic patch.
    void bound_strips(const detail::QuadShape::Patch& cell, const Piece& piece);
    /// @param piece  in the net's parameters, the longest side first
    void bound_part(const detail::Net16& net, const Piece& piece);
    const detail::SexticWeights& weights_over(const Corners& at);

    /// Bound on the error over a piece of an irregular cell: by norms, else by the hull of its points.
    /// @param may_split  as hull_error() has it
    double irregular_error(const detail::QuadNode& cell, const Piece& piece, bool may_split) const;

    const QuadPatches& patches_;
    // The way to the last leaf, by level: leaves in path order share it. What it gives does not depend on it.
    HalfedgeId root_;
    std::uint64_t times_forgotten_ = 0;  ///< as the patches had it when the cells were reached
    std::vector<Cell> path_{};
    std::vector<std::pair<Corners, detail::SexticWeights>> weights_{};  ///< by triangles they are for
};

}  // namespace tetrakis
