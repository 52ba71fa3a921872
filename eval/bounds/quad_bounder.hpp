#pragma once

#include "../surface/quad_cell_walk.hpp"
#include "leaf_error.hpp"
#include "triangle_distance.hpp"

#include <array>
#include <span>

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
class QuadBounder {
  public:
    explicit QuadBounder(const QuadPatches& patches);

    /// The error of a leaf, or bounds on it: refined until they lie on one side of `decide_at` or within a twentieth.
    /// @param slack  at edges where there is some, the error is that of EdgeSlack
    LeafError leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSlack& slack = {});

    /// Certified bound, tight to a twentieth where it exceeds `floor`: the largest over many leaves takes little more
    /// than one pass.
    double certified_error(const CellTriangle& leaf, double floor, const EdgeSlack& slack = {});

    /// Size of S - L over the depth-0 leaf of a root, L linear over each of its two cells with the value at the face's
    /// centre given (it need not lie on the surface).
    LeafError root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject = true);

    /// Corners, the deviation in the middle of the base edge. Depth-0 leaves included.
    QuickError quick_error(const CellTriangle& leaf);

    /// Samples of a leaf on a barycentric lattice with n intervals a side: (n + 1)(n + 2) / 2 points in the order
    /// corner 2 first, rows parallel to the edge corner 0 - corner 1. Positions and (unnormalised) normals of the limit
    /// surface.
    void sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions, std::span<Vec3d> normals);

  private:
    /// A triangle made of half a cell (right angle at corner `turn`: corners turn, turn + 1, turn + 3), or of a quarter
    /// (corners: the cell's centre, turn, turn + 1).
    struct Piece {
        HalfedgeId root;
        int level = 0;
        std::uint64_t x = 0, y = 0;
        int turn = 0;
        bool quarter = false;
        std::array<std::int8_t, 3> edge{-1, -1, -1};  ///< of the leaf that edge k (corner k to k + 1) lies on, or -1
    };
    /// What the quadratic through six points of a piece leaves of the surface.
    struct Remainder {
        double whole = 0;              ///< anywhere, in any direction
        double height = 0;             ///< along the normal of the leaf's triangle
        std::array<double, 3> edge{};  ///< on edge k of the piece
        Remainder operator*(double factor) const {
            return {whole * factor, height * factor, {edge[0] * factor, edge[1] * factor, edge[2] * factor}};
        }
    };
    struct Corners {
        std::array<Vec3d, 3> linear;     ///< L at the piece's corners
        std::array<Vec3d, 3> deviation;  ///< S - L there
    };

    static bool is_root(const CellTriangle& leaf);
    static Piece piece_of(const CellTriangle& leaf);
    detail::WalkCell& home(const Piece& piece) { return walk_.cell(piece.root, piece.level, piece.x, piece.y); }
    static Corners leaf_corners(detail::WalkCell& cell, const Piece& piece);
    void start(double decide_at, bool may_reject);
    LeafError finish() const;
    void bound_root(HalfedgeId root, const Vec3d* centre, const EdgeSlack& slack);
    void bound(const Piece& piece, const Corners& corners, int depth);
    void bound(detail::WalkCell& cell, const Piece& piece, const Corners& corners, int depth);
    void split(detail::WalkCell& cell, const Piece& piece, const Corners& corners, int depth);
    Remainder remainder(const detail::WalkCell::Patch& patch, const Piece& piece) const;
    /// Bounds a piece of a regular cell. False when it is not settled and splitting would help.
    bool bound_regular(const detail::WalkCell::Patch& patch, const Piece& piece, const Corners& corners,
                       bool may_split);
    bool one_to_one(const detail::Net16& net, const Piece& piece) const;
    bool bound_flat(const detail::Net16& net, const Piece& piece, const Remainder& rest);
    bool bound_on_lattice(const detail::WalkCell::Patch& patch, const Piece& piece, const Corners& corners,
                          const Remainder& rest, bool may_split);
    /// Part of a piece within one bicubic net: any triangle in the net's parameters.
    struct Part {
        std::array<Vec2d, 3> at;
        std::array<Vec3d, 3> surface, linear;
        std::array<std::int8_t, 3> edge;  ///< as of Piece
    };
    /// Bounds a piece of a cell with a crease of finite sharpness, strip by strip. False when it is not settled.
    bool bound_strips(detail::WalkCell& cell, const Piece& piece, const Corners& corners);
    bool bound_part(const detail::Net16& net, const detail::ThirdBounds& third, const Part& part, int depth);
    /// Bound on a piece of a star's cell with its corner at the star's, from the surface's first-order part; infinite
    /// where it does not apply.
    double tip_error(const detail::QuadNode& node, const Piece& piece, const Corners& corners) const;
    double hull_error(const detail::QuadNode& node, const Piece& piece, const Corners& corners) const;
    double quadratic_error(const std::array<Vec3d, 3>& corner, const std::array<Vec3d, 3>& middle,
                           const std::array<std::int8_t, 3>& edge, const Remainder& rest) const;
    struct FlatError {
        bool known = false;
        double attained = 0;  ///< at the middles of the edges
        double on_edges = 0;  ///< bound on the edges' errors
        double height = 0;    ///< bound on heights over the plane
        double beside = 0;    ///< bound on how far the surface reaches beyond the leaf,
        double reach = 0;     ///< and on how far its sides do
    };
    FlatError flat_error(const std::array<Vec3d, 3>& middle, const Remainder& rest) const;
    /// The form in which errors are measured: positions in the triangle's frame, or S - L.
    Vec3d measured_form(const Vec3d& position, const Vec3d& deviation) const {
        return distance_ ? triangle_.local(position) : deviation;
    }
    double node_error(const Vec3d& node, int edge) const;
    void measure_distance(const std::array<Vec3d, 3>& corners, const EdgeSlack& slack);
    void set_slack(const EdgeSlack& slack);
    void need_triangle();
    bool settled(double upper);
    /// Whether no more pieces of this leaf are to be split: those that are left count by what is known of them.
    bool exhausted() const { return splits_ >= k_most_splits; }
    /// Takes note of an error that is attained. False when that rejects the leaf.
    bool attain(double error);

    const QuadPatches& patches_;
    double scale_ = 0;  ///< largest coordinate, for the rounding pad
    detail::QuadCellWalk walk_;
    // State of one call.
    double decide_at_ = 0, lower_ = 0, upper_ = 0;
    double stretch_ = 1;  ///< all three are divided by it
    static constexpr int k_most_splits = 1 << 10;
    int splits_ = 0;
    bool rejected_ = false, may_reject_ = true;
    bool distance_ = false;              ///< to the leaf's triangle; else S - L counts
    std::array<Vec3d, 3> leaf_;          ///< corners, where distance_ is set
    detail::TriangleDistance triangle_;  ///< of leaf_, once need_triangle() was called
    bool has_triangle_ = false;
};

}  // namespace tetrakis
