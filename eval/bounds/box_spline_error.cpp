#include "box_spline_error.hpp"

#include "triangle_deviation.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

namespace {

/// Along the difference of two points: -(d0 d1 D01 + d1 d2 D12 + d2 d0 D20), as for any quadratic form.
std::array<double, 3> along_weights(const Bary& d) { return {-d[0] * d[1], -d[1] * d[2], -d[2] * d[0]}; }

}  // namespace

BoxSplineHessian restricted(const BoxSplineHessian& h, const std::array<Bary, 3>& at, int parallel) {
    const double size = std::abs(at[1][static_cast<std::size_t>(parallel)] - at[0][static_cast<std::size_t>(parallel)]);
    const double scale = size * size;
    BoxSplineHessian out;
    for (std::size_t e = 0; e < 3; ++e) {
        const std::size_t p = (e + static_cast<std::size_t>(parallel)) % 3;
        for (std::size_t i = 0; i < 3; ++i) out.corner[e][i] = scale * h.along(static_cast<int>(p), at[i]);
        out.bend[e] = (scale * scale) * h.bend[p];
    }
    return out;
}

std::array<EdgeSecond, 3> edge_seconds(const BoxSplineHessian& h, const std::array<Bary, 3>& at) {
    std::array<std::array<Vec3d, 3>, 3> along;  // [patch edge][corner]
    for (int e = 0; e < 3; ++e)
        for (int i = 0; i < 3; ++i) along[e][i] = h.along(e, at[i]);
    std::array<Bary, 3> difference;
    for (int i = 0; i < 3; ++i) {
        const Bary &a = at[i], &b = at[next3(i)];
        difference[i] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    }
    // The blossom of a product of two coordinates lies below the mean by half the product of their differences.
    std::array<std::array<double, 3>, 3> below;  // [patch edge][edge]
    for (int e = 0; e < 3; ++e)
        for (int i = 0; i < 3; ++i) below[e][i] = 0.5 * difference[i][e] * difference[i][next3(e)];
    std::array<EdgeSecond, 3> out;
    for (int k = 0; k < 3; ++k) {
        const std::array<double, 3> weight = along_weights(difference[k]);
        double largest = 0;
        for (int i = 0; i < 3; ++i) {
            out[k].corner[i] = weight[0] * along[0][i] + weight[1] * along[1][i] + weight[2] * along[2][i];
            largest = std::max(largest, squared(out[k].corner[i]));
        }
        for (int i = 0; i < 3; ++i) {
            const Vec3d control = 0.5 * (out[k].corner[i] + out[k].corner[next3(i)]) -
                                  ((weight[0] * below[0][i]) * h.bend[0] + (weight[1] * below[1][i]) * h.bend[1] +
                                   (weight[2] * below[2][i]) * h.bend[2]);
            largest = std::max(largest, squared(control));
            if (i == k) out[k].along_edge = control;
        }
        out[k].bound = std::sqrt(largest);
    }
    return out;
}

double patch_deviation(const BoxSplineHessian& h) {
    std::array<double, 3> bound;
    for (int e = 0; e < 3; ++e) {
        const auto& c = h.corner[e];
        const Vec3d along_edge = 0.5 * (c[e] + c[next3(e)] + h.bend[e]);
        bound[e] = std::sqrt(std::max({squared(c[0]), squared(c[1]), squared(c[2]), squared(along_edge)}));
    }
    return triangle_deviation(bound[0], bound[1], bound[2]);
}

/// S - L at the centroid: two thirds of the deviation in the middle of edge 1, plus what the median from corner 0 to it
/// bends. 13, 22 and 19 over 486 are the integrals of the Bernstein polynomials against the Green function at 2/3.
Vec3d centroid_deviation(const BoxSplineHessian& h, const std::array<Bary, 3>& at, const Vec3d& middle_of_edge_1) {
    const Bary &a = at[0], m = middle(at[1], at[2]);
    const Bary d{m[0] - a[0], m[1] - a[1], m[2] - a[2]};
    const std::array<double, 3> weight = along_weights(d);
    Vec3d first(0), last(0), bend(0);
    for (int e = 0; e < 3; ++e) {
        first += weight[e] * h.along(e, a);
        last += weight[e] * h.along(e, m);
        bend += (weight[e] * d[e] * d[next3(e)]) * h.bend[e];
    }
    const Vec3d control = 0.5 * (first + last) - 0.5 * bend;
    return (2.0 / 3) * middle_of_edge_1 - (1.0 / 486) * (13.0 * first + 22.0 * control + 19.0 * last);
}

}  // namespace tetrakis::detail
