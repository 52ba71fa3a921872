#pragma once

#include "tetrakis/eval/leaf_error.hpp"
#include "tetrakis/eval/loop_patches.hpp"

#include <array>
#include <span>
#include <vector>

namespace tetrakis {

/// Errors of leaves of triangle quadtrees (red triangles, and the halves and quarters of their green closure) against a
/// Loop limit surface. Keeps the way down to the last leaf's patch, so that leaves asked for in path order share it.
/// One per thread; results depend on the leaf alone.
class LoopBounder {
  public:
    explicit LoopBounder(const LoopPatches& patches);

    /// Parametric error: the size of S - L over the leaf, L the linear interpolant of the leaf's three limit points. It
    /// bounds the distance in both directions. Refines the bound until it lies on one side of `decide_at` or is tight
    /// to a twentieth; where `lower` exceeds `decide_at`, `upper` may be infinite.
    LeafError parametric_error(const CellTriangle& leaf, double decide_at);

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
    using Corners = std::array<detail::Bary, 3>;
    /// A triangle within a cell: coordinates of its corners in the cell's frame, L and S - L there.
    struct Piece {
        Corners at;
        std::array<Vec3d, 3> linear, deviation;
    };

    Level& locate(const CellTriangle& leaf, Corners& at);
    void bound_star(const detail::LoopStarChain& star, const Piece& piece, int depth);
    void bound_irregular(const detail::LoopCell& cell, const Piece& piece, int depth);
    /// A whole cell, quarter by quarter.
    /// @param middles  S - L in the middles of its edges, if that is known
    /// @param settled  quarters that need no look
    void bound_quarters(const detail::LoopCell& cell, const Piece& piece, int depth,
                        const std::array<Vec3d, 3>* middles = nullptr, const std::array<bool, 4>& settled = {});
    void bound_green(const detail::LoopCell& cell, const Piece& piece, int corners, int depth);
    void bound_quarter(const detail::LoopCell& cell, int quarter, const Piece& piece, int depth);
    using Deviations = std::array<Vec3d, 3>;
    /// @param hessian  on the piece itself
    /// @param own      known bound on |S - L'|, L' the interpolant of the piece's own corners
    void bound_red(const detail::BoxSplineHessian& hessian, const Deviations& deviation, double own, int depth);
    /// @param hessian  of the patch
    void bound_regular(const detail::BoxSplineHessian& hessian, const Corners& at, const Deviations& deviation,
                       double own, int depth);
    bool attain_inner(const std::array<Vec3d, 3>& inner, double attained, double own);
    Vec3d corner_or_inner(const detail::LoopCell& cell, const detail::Bary& at) const;
    bool accept(double upper);
    bool settle(double upper);
    void attain(const Vec3d& deviation);

    const LoopPatches& patches_;
    double pad_ = 0;  ///< rounding errors
    HalfedgeId root_;
    std::vector<Level> way_;
    int known_ = 0;  ///< levels of way_ that belong to root_
    // State of one parametric_error() call.
    double decide_at_ = 0, lower_ = 0, upper_ = 0;
    bool rejected_ = false;
};

}  // namespace tetrakis
