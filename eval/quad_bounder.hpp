#pragma once

#include "tetrakis/eval/leaf_error.hpp"
#include "tetrakis/eval/quad_patches.hpp"
#include "tetrakis/eval/second_bounds.hpp"

#include <array>
#include <span>

namespace tetrakis {

/// Errors of bisection leaves against the limit surface of Catmull-Clark. Walks down to a leaf's cell by subdividing
/// nets and keeps the way, so that leaves asked for in path order share it. One per thread; results depend on the leaf
/// alone.
class QuadBounder {
  public:
    explicit QuadBounder(const QuadPatches& patches);

    /// Parametric error: the size of S - L over the leaf, L the linear interpolant of the leaf's three limit points. It
    /// bounds the distance in both directions. Refines the bound until it lies on one side of `decide_at` or is tight
    /// to a twentieth.
    LeafError parametric_error(const CellTriangle& leaf, double decide_at);

    /// Certified bound, tight to a twentieth where it exceeds `floor`: the largest over many leaves takes little more
    /// than one pass.
    double certified_error(const CellTriangle& leaf, double floor);

    /// The same for the depth-0 leaf of a root, with L's value at the face's centre given (it need not lie on the
    /// surface).
    LeafError root_error(HalfedgeId root, const Vec3d& centre, double decide_at, bool may_reject = true);

    /// Corners, the deviation in the middle of the base edge, and the bound that costs nothing more. Depth-0 leaves
    /// included.
    QuickError quick_error(const CellTriangle& leaf, double decide_at);

    /// Samples of a leaf on a barycentric lattice with n intervals a side: (n + 1)(n + 2) / 2 points in the order
    /// corner 2 first, rows parallel to the edge corner 0 - corner 1. Positions and (unnormalised) normals of the limit
    /// surface.
    void sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions, std::span<Vec3d> normals);

  private:
    struct Cell {
        const detail::QuadNode* node = nullptr;  ///< irregular node, or regular node of the tree, or null below it
        const detail::Net16* net = nullptr;      ///< regular cells
        detail::SideCrease crease;
        std::uint64_t x = 0, y = 0;
        std::uint8_t known = 0;  ///< bit k: corner[k] is there
        bool has_bounds = false;
        std::array<Vec3d, 4> corner;
        detail::SecondBounds bounds;
        bool irregular() const { return net == nullptr; }
    };
    /// A triangle made of half a cell (right angle at corner `turn`: corners turn, turn + 1, turn + 3), or of a quarter
    /// (base: side `turn`, apex: the cell's centre).
    struct Piece {
        HalfedgeId root;
        int level = 0;
        std::uint64_t x = 0, y = 0;
        int turn = 0;
        bool quarter = false;
    };
    struct Corners {
        std::array<Vec3d, 3> linear;     ///< L at the piece's corners
        std::array<Vec3d, 3> deviation;  ///< S - L there
    };

    Cell& cell(HalfedgeId root, int level, std::uint64_t x, std::uint64_t y);
    static Vec3d cell_corner(Cell& cell, int corner);
    static Vec3d cell_point(const Cell& cell, double x, double y);
    static double deviation(Cell& cell, const Piece& piece);
    static double hull_distance(const Cell& cell, const std::array<Vec3d, 3>& linear);
    static bool is_root(const CellTriangle& leaf);
    static Piece piece_of(const CellTriangle& leaf);
    Corners leaf_corners(const Piece& piece);
    void bound_root(HalfedgeId root, const Vec3d* centre);
    void bound_regular(Cell& home, const Piece& piece, const Corners& corners, double attained);
    static double largest_deviation(const detail::Net16& net, const Piece& piece, const Corners& corners, int n);
    void bound(const Piece& piece, const Corners& corners, int depth);

    const QuadPatches& patches_;
    double scale_ = 0;  ///< largest coordinate, for the rounding pad
    HalfedgeId root_;
    std::vector<Cell> cells_;
    std::vector<detail::Net16> nets_;
    int depth_ = -1;
    // State of one parametric_error() call.
    double decide_at_ = 0, lower_ = 0, upper_ = 0;
    bool rejected_ = false, may_reject_ = true;
};

}  // namespace tetrakis
