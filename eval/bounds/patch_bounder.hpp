#pragma once

#include "../patches/bezier_triangle.hpp"
#include "../triangles/face_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace tetrakis {

/// Bounds on the distance between a surface and a triangle of a hierarchy.
struct LeafError {
    double lower = 0;  ///< attained at a sample
    double upper = 0;  ///< never exceeded (rounding included)
};

}  // namespace tetrakis

namespace tetrakis::detail {

/// Number and barycentrics of the points of a lattice with n intervals a side: rows from corner 2 towards the edge from
/// corner 0 to corner 1.
template <class Visit>
void for_each_lattice_point(int n, Visit&& visit) {
    int index = 0;
    for (int row = 0; row <= n; ++row)
        for (int i = 0; i <= row; ++i, ++index)
            visit(index, static_cast<double>(row - i) / n, static_cast<double>(i) / n,
                  static_cast<double>(n - row) / n);
}

/// Bounds the error of one leaf over polynomial patches. Errors are convex functions of a point, so the largest over a
/// patch's control points bounds them. Patches are bisected until this bound lies on one side of the tolerance, or
/// within a twentieth of an attained error.
class PatchBounder {
  protected:
    /// For each side of a piece (corner k to k + 1) the edge of the leaf that it lies on, or -1.
    using Edges = std::array<int, 3>;

    /// @param rounding  surface_rounding()
    explicit PatchBounder(double rounding) : pad_(rounding) {}

    void start(double decide_at, bool may_reject) {
        decide_at_ = decide_at;
        may_reject_ = may_reject;
        lower_ = upper_ = 0;
        splits_ = 0;
        stretch_ = 1;
        rejected_ = false;
    }
    LeafError finish() const {
        if (rejected_) return {stretch_ * lower_, std::numeric_limits<double>::infinity()};
        return {stretch_ * lower_, stretch_ * std::max(upper_, lower_)};
    }
    /// After start(), once face_ is set.
    void start_with_face() {
        stretch_ = face_.stretch();
        if (stretch_ > 1) decide_at_ /= stretch_ * k_stretch_rounding;
    }

    /// @param node  a point in the face's frame
    /// @param edge  edge of the leaf to which the distance counts; -1: the distance to the face counts
    double node_error(const Vec3d& node, int edge) const {
        return edge >= 0 ? face_.to_edge(node, static_cast<std::size_t>(edge)) : face_.to_face(node);
    }
    /// The largest error at the corners of a piece. No error on the piece exceeds it by more than the surface's
    /// distance from the linear interpolant of these corners: errors are convex, and change no faster than points move.
    double corner_error(const std::array<Vec3d, 3>& corner, const Edges& edge) const {
        double most = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const int before = edge[(k + 2) % 3];
            most = std::max(most, node_error(corner[k], edge[k]));
            if (before != edge[k]) most = std::max(most, node_error(corner[k], before));
        }
        return most;
    }
    /// Bound on the error over a piece that lies, with its sides, in the convex hull of these points.
    /// @param may_split  then any value that does not settle the piece may be returned if the bound does not settle it
    template <class Points>
    double hull_error(const Points& points, const Edges& edge, bool may_split) const {
        double error = 0;
        for (const Vec3d& p : points) {
            const Vec3d local = face_.local(p);
            error = std::max(error, node_error(local, -1));
            for (const int e : edge)
                if (e >= 0) error = std::max(error, node_error(local, e));
            if (may_split && !is_settled(error + pad_)) break;
        }
        return error;
    }
    /// Records an error that is attained. Returns false if the leaf is rejected.
    bool attain(double error) {
        lower_ = std::max(lower_, error);
        rejected_ |= may_reject_ && lower_ > decide_at_;
        return !rejected_;
    }
    /// Whether a piece with this bound needs no further work.
    bool is_settled(double upper) const {
        return upper <= decide_at_ || upper <= 1.05 * lower_ + pad_ || upper <= upper_;
    }
    /// The same; if so, records the bound.
    bool settled(double upper) {
        if (!is_settled(upper)) return false;
        upper_ = std::max(upper_, upper);
        return true;
    }
    /// Whether a piece must be split; if not, records its bound. With `depth` 0 or after k_most_splits splits of a
    /// leaf, pieces are not split, and their bounds count.
    /// @param bound  double bound(may_split)
    template <class Bound>
    bool needs_split(int depth, Bound&& bound) {
        const bool may_split = depth > 0 && splits_ < k_most_splits;
        const double upper = bound(may_split) + pad_;
        if (settled(upper)) return false;
        if (may_split)
            ++splits_;
        else
            upper_ = std::max(upper_, upper);
        return may_split;
    }

    /// @param edge  of the patch's sides
    template <int Degree>
    void bound_patch(const BezierTriangle<Degree>& patch, const Edges& edge, int depth = k_most_bisections) {
        using Patch = BezierTriangle<Degree>;
        if (rejected_) return;
        FaceDistance::Squares squares;
        const bool squared = face_.has_squares();
        if (squared)
            face_.squares({patch.c[0].data(), patch.c[1].data(), patch.c[2].data()}, patch.c[0].size(), squares);
        const auto size = [&](std::size_t i, int e) {
            return squared ? squares[static_cast<std::size_t>(e + 1)][i] : node_error(face_.local(patch[i]), e);
        };
        const auto error_of = [&](double largest) { return squared ? std::sqrt(largest) : largest; };
        double at_corners = 0;
        for (std::size_t k = 0; k < 3; ++k)
            for (const int e : {edge[k], edge[(k + 2) % 3]})
                at_corners = std::max(at_corners, size(Patch::corner(k), e));
        if (!attain(error_of(at_corners))) return;
        const auto bound = [&](bool may_split) {
            double most = 0;
            for (const std::size_t side : {3u, 0u, 1u, 2u}) {
                const int e = side < 3 ? edge[side] : -1;
                const std::span points(Patch::k_on_side[side].data(), Patch::on_side(side));
                for (const std::size_t i : points) {
                    if (!squared && may_split && !is_settled(std::max(lower_, most) + pad_)) return lower_ + most;
                    most = std::max(most, size(i, e));
                }
            }
            return std::max(lower_, error_of(most));
        };
        if (!needs_split(depth, bound)) return;
        const auto [first, second] = patch.halves();
        bound_patch(first, {edge[2], edge[0], -1}, depth - 1);
        bound_patch(second, {edge[1], -1, edge[0]}, depth - 1);
    }

    double pad_;  ///< rounding
    // State of one call; decide_at_, lower_ and upper_ are divided by stretch_.
    double decide_at_ = 0, lower_ = 0, upper_ = 0, stretch_ = 1;
    int splits_ = 0;
    bool rejected_ = false, may_reject_ = true;
    FaceDistance face_;

  private:
    /// Depth of nested bisections: by then a patch is a point but for rounding.
    static constexpr int k_most_bisections = 48;
    static constexpr int k_most_splits = 1 << 12;
};

}  // namespace tetrakis::detail
