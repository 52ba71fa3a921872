#pragma once

#include "../surface/loop_patches.hpp"
#include "leaf_error.hpp"
#include "triangle_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace tetrakis {

/// Errors of leaves of triangle quadtrees (red triangles, and the halves and quarters of their green closure) against a
/// Loop limit surface. Keeps the way down to the last leaf's patch, so that leaves asked for in path order share it.
/// One per thread; results depend on the leaf alone.
///
/// The error of a leaf with triangle T over the piece S of the surface is QuadBounder's: the largest of the distance
/// from a point of S to T, and the distance from a point of S on a side of the leaf to that edge of T. It bounds the
/// distance in both directions.
class LoopBounder {
  public:
    explicit LoopBounder(const LoopPatches& patches);

    /// Bounds on the error of a leaf, refined until they lie on one side of `decide_at` or within a twentieth; where
    /// `lower` exceeds `decide_at`, `upper` may be infinite.
    /// @param slack  at edges where there is some, the error is that of EdgeSlack
    LeafError leaf_error(const CellTriangle& leaf, double decide_at, const EdgeSlack& slack = {});

    /// Samples of a leaf on a barycentric lattice with n intervals a side: (n + 1)(n + 2) / 2 points in the order
    /// corner 2 first, rows parallel to the edge corner 0 - corner 1. Positions and (unnormalised) normals of the limit
    /// surface.
    /// @param normals  may be empty
    void sample(const CellTriangle& leaf, int n, std::span<Vec3d> positions, std::span<Vec3d> normals);

  private:
    struct Level {
        detail::LoopCell cell;
        int quarter = -1;  ///< of the level above
        bool has_hessian = false;
        detail::BoxSplineHessian hessian;
        double patch_deviation = 0;  ///< with the hessian
    };
    /// Pieces of regular patches are quartered at most this often: what a patch adds to an attained error is by then a
    /// few thousandths of what it adds at first. Where hardly any error is attained, as on a flat sheet whose
    /// parameters run unevenly, no bound is ever within a twentieth of it.
    static constexpr int k_regular_refinement = 6;
    /// Nor are more pieces of a leaf split than this; those that are left count by what is known of them.
    static constexpr int k_most_splits = 1 << 13;
    /// No bound yet.
    static constexpr double k_unknown = std::numeric_limits<double>::infinity();

    using Corners = std::array<detail::Bary, 3>;
    /// A point of the surface, or of a linear interpolant of such points.
    struct Point {
        double b1 = 0, b2 = 0;  ///< the leaf's parameters: L is the point of T with these barycentrics
        Vec3d deviation{0};     ///< from L
        double error = 0;       ///< distance to T; on a side of the leaf, to that edge of T
    };
    using Points = std::array<Point, 3>;
    /// A triangle within a cell: its corners in the cell's frame.
    ///
    /// The error is convex, so where S differs from the linear interpolant of a piece's corners by at most e, S has at
    /// most the largest error of the corners plus e. Never below the error, and cheaper, is the size of S - L.
    struct Piece {
        Corners at;
        Points point;
    };

    static double largest_error(const Points& p) { return std::max({p[0].error, p[1].error, p[2].error}); }
    /// Linear in parameters and deviation; the error is left open.
    static Point halfway(const Point& a, const Point& b);
    static Point combine(const Points& corner, const detail::Bary& at);
    /// Whether a line between two points lies on a side of the leaf.
    static bool on_one_side(const Point& a, const Point& b);

    Level& locate(const CellTriangle& leaf, Corners& at);
    void bound_star(const detail::LoopStarChain& star, const Piece& piece, int depth);
    bool bound_star_part(const detail::LoopStarChain& star, const Piece& piece);
    void bound_irregular(const detail::LoopCell& cell, const Piece& piece, int depth);
    /// A whole cell, quarter by quarter.
    /// @param middles  of its edges, if they are known
    /// @param settled  quarters that need no look
    void bound_quarters(const detail::LoopCell& cell, const Piece& piece, int depth, const Points* middles = nullptr,
                        const std::array<bool, 4>& settled = {});
    void bound_green(const detail::LoopCell& cell, const Piece& piece, int corners, int depth);
    void bound_quarter(const detail::LoopCell& cell, int quarter, const Piece& piece, int depth);
    /// @param hessian  on the piece itself
    /// @param own      known bound on |S - L'|, L' the interpolant of the piece's own corners
    void bound_red(const detail::BoxSplineHessian& hessian, const Points& point, double own, int depth);
    /// @param hessian  of the patch
    void bound_regular(const detail::BoxSplineHessian& hessian, const Corners& at, const Points& point, double own,
                       int depth);
    bool may_split(int depth) { return depth > 0 && splits_++ < k_most_splits; }
    bool attain_inner(Points& inner, double attained, double own);
    void attain_centroid(const Points& point, const Vec3d& bend);
    double hull_error(const detail::LoopCell& cell, const Points& point) const;
    Vec3d linear(const Point& point) const { return corners_[0] + point.b1 * side_[0] - point.b2 * side_[2]; }
    double error_of(const Point& point);
    double to_side(const Point& point, std::size_t k) const;
    double to_triangle(const Point& point);
    void set_leaf(const std::array<Vec3d, 3>& corners, const EdgeSlack& slack);
    bool set_slack(const EdgeSlack& slack);
    Vec3d corner_or_inner(const detail::LoopCell& cell, const detail::Bary& at) const;
    bool accept(double upper);
    bool settle(double upper);
    void attain(Point& point);
    /// Whether S - L and `rest` are acceptable together. The size of S - L, which is never below the error and cheaper,
    /// stands for it then.
    bool small(Point& point, double rest) const {
        const double room = decide_at_ - rest, size = glm::dot(point.deviation, point.deviation);
        if (!(room >= 0 && size <= room * room)) return false;
        point.error = std::sqrt(size);
        return true;
    }
    void attain_where_needed(Point& point, double rest) {
        if (!small(point, rest)) attain(point);
    }
    Point surface_halfway(const Point& a, const Point& b, const Vec3d& surface);

    const LoopPatches& patches_;
    double pad_ = 0;  ///< rounding errors
    HalfedgeId root_;
    std::vector<Level> way_;
    int known_ = 0;  ///< levels of way_ that belong to root_
    // State of one leaf_error() call.
    double decide_at_ = 0, lower_ = 0, upper_ = 0;
    double stretch_ = 1;  ///< all three are divided by it
    int splits_ = 0;
    bool rejected_ = false;
    std::array<Vec3d, 3> corners_, side_;      ///< of T; side k from corner k to the next
    std::array<double, 3> inverse_squared_{};  ///< lengths of the sides; 0 for no length
    bool has_triangle_ = false;
    detail::TriangleDistance triangle_;  ///< where has_triangle_ is set
};

}  // namespace tetrakis
