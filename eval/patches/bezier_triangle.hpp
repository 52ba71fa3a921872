#pragma once

#include "../../hier/base/vec.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <utility>

namespace tetrakis::detail {

/// A polynomial over a triangle in Bernstein-Bezier form. It lies in the convex hull of its control points, and each
/// side of it in the convex hull of the control points on that side.
template <int Degree>
class BezierTriangle {
  public:
    static constexpr std::size_t k_count = (Degree + 1) * (Degree + 2) / 2;

    /// Index of the control point whose exponents at corners 0, 1, 2 are Degree - i - j, i, j.
    static constexpr std::size_t index(int i, int j) {
        return static_cast<std::size_t>(j * (Degree + 1) - j * (j - 1) / 2 + i);
    }
    static constexpr std::size_t corner(std::size_t k) {
        return k == 0 ? index(0, 0) : k == 1 ? index(Degree, 0) : index(0, Degree);
    }

    static constexpr std::size_t k_lanes = 4;  ///< coordinates fill whole registers of so many numbers
    using Coordinates = std::array<double, (k_count + k_lanes - 1) / k_lanes * k_lanes>;
    std::array<Coordinates, 3> c{};  ///< by coordinate, then by control point

    Vec3d operator[](std::size_t i) const { return {c[0][i], c[1][i], c[2][i]}; }
    Vec3d operator()(int i, int j) const { return (*this)[index(i, j)]; }
    std::array<Vec3d, k_count> points() const {
        std::array<Vec3d, k_count> all;
        for (std::size_t i = 0; i < k_count; ++i) all[i] = (*this)[i];
        return all;
    }
    void set(int i, int j, const Vec3d& p) {
        for (std::size_t k = 0; k < 3; ++k) c[k][index(i, j)] = p[static_cast<int>(k)];
    }

    /// Control points on side k (from corner k to the next), its ends left out; those on side 3 are inside.
    static constexpr std::size_t on_side(std::size_t k) { return k < 3 ? Degree - 1 : (Degree - 1) * (Degree - 2) / 2; }
    static constexpr std::array<std::array<std::size_t, k_count>, 4> k_on_side = [] {
        std::array<std::array<std::size_t, k_count>, 4> table{};
        std::array<std::size_t, 4> size{};
        for (int j = 0; j <= Degree; ++j)
            for (int i = 0; i + j <= Degree; ++i) {
                const bool on0 = j == 0, on1 = i + j == Degree, on2 = i == 0;
                const std::size_t side = on0 ? 0 : on1 ? 1 : on2 ? 2 : 3;
                if (on0 + on1 + on2 < 2) table[side][size[side]++] = index(i, j);
            }
        return table;
    }();

    /// The polar form with Degree - N arguments equal to `at`: the control net after Degree - N steps of de Casteljau's
    /// algorithm. Differences of its points give the derivatives at `at`.
    template <int N>
    BezierTriangle<N> around(const std::array<double, 3>& at) const {
        if constexpr (N == Degree) {
            return *this;
        } else {
            const BezierTriangle<N + 1> before = around<N + 1>(at);
            BezierTriangle<N> result;
            for (int j = 0; j <= N; ++j)
                for (int i = 0; i + j <= N; ++i)
                    result.set(i, j, at[0] * before(i, j) + at[1] * before(i + 1, j) + at[2] * before(i, j + 1));
            return result;
        }
    }

    /// The same polynomial over another triangle, by the barycentrics of its corners in this one.
    BezierTriangle over(const std::array<std::array<double, 3>, 3>& corners) const {
        BezierTriangle result;
        result.take_arguments(points(), Degree, corners, 0, 0, 0);
        return result;
    }

    /// Cuts the triangle from corner 2 to the middle m of side 0. With corners a, b, c the parts have the corners
    /// (c, a, m) and (b, c, m), so that side 0 of each is a whole side of this one.
    std::pair<BezierTriangle, BezierTriangle> halves() const {
        std::pair<BezierTriangle, BezierTriangle> result;
        for (std::size_t k = 0; k < 3; ++k)
#pragma GCC unroll 8
            for (int j = 0; j <= Degree; ++j) {
                // De Casteljau's algorithm at 1/2 along a row parallel to side 0.
                const int n = Degree - j;
                std::array<double, Degree + 1> row;
#pragma GCC unroll 8
                for (int i = 0; i <= n; ++i) row[static_cast<std::size_t>(i)] = c[k][index(i, j)];
#pragma GCC unroll 8
                for (int step = 0; step <= n; ++step) {
                    // Exponents (n - step, step) of a and m, and of b and m; j of c.
                    result.first.c[k][index(n - step, step)] = row[0];
                    result.second.c[k][index(j, step)] = row[static_cast<std::size_t>(n - step)];
#pragma GCC unroll 8
                    for (int i = 0; i + step < n; ++i) {
                        const auto at = static_cast<std::size_t>(i);
                        row[at] = 0.5 * (row[at] + row[at + 1]);
                    }
                }
            }
        return result;
    }

  private:
    /// Inserts the last `left` arguments, from corner `first` on; i of the earlier ones are corner 1, j are corner 2.
    void take_arguments(const std::array<Vec3d, k_count>& polar, int left,
                        const std::array<std::array<double, 3>, 3>& corners, std::size_t first, int i, int j) {
        if (left == 0) return set(i, j, polar[0]);
        for (std::size_t k = first; k < 3; ++k) {
            // One step of de Casteljau's algorithm; each row of `polar` has one point less than the row before.
            std::array<Vec3d, k_count> next;
            std::size_t out = 0, row = 0;
            for (int n = left; n > 0; row += static_cast<std::size_t>(n) + 1, --n)
                for (std::size_t m = 0; m < static_cast<std::size_t>(n); ++m) {
                    const std::size_t at = row + m, above = row + static_cast<std::size_t>(n) + 1 + m;
                    next[out++] =
                        corners[k][0] * polar[at] + corners[k][1] * polar[at + 1] + corners[k][2] * polar[above];
                }
            take_arguments(next, left - 1, corners, k, i + (k == 1), j + (k == 2));
        }
    }
};

/// The polynomial whose control points are sums of points times weights, of which each point has one for each control
/// point. For degrees 1, 4 and 6.
template <int Degree>
BezierTriangle<Degree> combined(std::span<const Vec3d> points,
                                std::span<const typename BezierTriangle<Degree>::Coordinates> weights);

}  // namespace tetrakis::detail
