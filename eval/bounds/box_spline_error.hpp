#pragma once

#include "../surface/box_spline.hpp"

#include <array>
#include <cmath>

namespace tetrakis::detail {

constexpr int next3(int i) { return i == 2 ? 0 : i + 1; }
constexpr int prev3(int i) { return i == 0 ? 2 : i - 1; }

inline double squared(const Vec3d& v) { return glm::dot(v, v); }

inline Bary middle(const Bary& a, const Bary& b) {
    return {0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2])};
}

/// Second derivatives of a patch along an edge of a triangle within it, as a quadratic: its Bernstein coefficients on
/// the triangle at the corners and at the edge itself, and a bound on its norm.
struct EdgeSecond {
    std::array<Vec3d, 3> corner;
    Vec3d along_edge;  ///< the coefficient of the edge
    double bound = 0;  ///< of the norm over the triangle

    /// S - L in the middle of the edge, when it vanishes at both ends. The weights are the integrals of the three
    /// Bernstein polynomials against the Green function of the second derivative at 1/2.
    Vec3d middle_deviation(int edge) const {
        return (-1.0 / 192) * (7.0 * (corner[edge] + corner[next3(edge)]) + 10.0 * along_edge);
    }
};

/// The patch edge that is parallel to edge 0 of a triangle of the patch's quadtree, the others following in order; -1
/// for any other triangle.
inline int red_edge(const std::array<Bary, 3>& at) {
    for (int p = 0; p < 3; ++p) {
        const int p1 = next3(p), p2 = prev3(p);
        if (at[0][p2] == at[1][p2] && at[1][p] == at[2][p] && at[2][p1] == at[0][p1]) return p;
    }
    return -1;
}
/// Size of such a triangle relative to the patch; 0 for any other one.
inline double red_size(const std::array<Bary, 3>& at) {
    const int p = red_edge(at);
    return p < 0 ? 0.0 : std::abs(at[1][static_cast<std::size_t>(p)] - at[0][static_cast<std::size_t>(p)]);
}

/// Second derivatives of a patch on a triangle of its quadtree, along the triangle's own edges and in their order.
/// @param parallel  red_edge(at), not -1
BoxSplineHessian restricted(const BoxSplineHessian& hessian, const std::array<Bary, 3>& at, int parallel);

/// Of all three edges of a triangle within a patch (edge k from corner k to corner k + 1).
std::array<EdgeSecond, 3> edge_seconds(const BoxSplineHessian& hessian, const std::array<Bary, 3>& at);

/// Bound on |S - L| over the whole patch. A triangle of a quadtree within it, 2^-k times its size, has at most 4^-k of
/// it.
double patch_deviation(const BoxSplineHessian& hessian);

/// S - L in the middle of an edge of the patch, L the linear interpolant of its ends.
inline Vec3d middle_deviation(const BoxSplineHessian& h, int edge) {
    const auto e = static_cast<std::size_t>(edge), f = static_cast<std::size_t>(next3(edge));
    return (-1.0 / 192) * (12.0 * (h.corner[e][e] + h.corner[e][f]) + 5.0 * h.bend[e]);
}

/// S - L at the centroid, where L is the linear interpolant of S on the triangle.
/// @param middle_of_edge_1  S - L there
Vec3d centroid_deviation(const BoxSplineHessian& hessian, const std::array<Bary, 3>& at, const Vec3d& middle_of_edge_1);

}  // namespace tetrakis::detail
