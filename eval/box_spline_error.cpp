#include "tetrakis/eval/box_spline_error.hpp"

#include "tetrakis/eval/second_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

namespace {

/// For a triangle of a quadtree (edges parallel to the patch's): edge k of `at` is parallel to patch edge `parallel`.
EdgeSecond edge_second_red(const BoxSplineHessian& h, const std::array<Bary, 3>& at, int k, int parallel, double size) {
    EdgeSecond out;
    const double scale = size * size;
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        out.corner[i] = scale * h.along(parallel, at[i]);
        largest = std::max(largest, squared(out.corner[i]));
    }
    // The blossom of a product of two coordinates lies below the mean by half the product of their differences, here
    // -size^2.
    out.along_edge = 0.5 * (out.corner[k] + out.corner[next3(k)]) + (0.5 * scale * scale) * h.bend[parallel];
    out.bound = std::sqrt(std::max(largest, squared(out.along_edge)));
    return out;
}

/// Along the difference of two points: -(d0 d1 D01 + d1 d2 D12 + d2 d0 D20), as for any quadratic form.
std::array<double, 3> along_weights(const Bary& d) { return {-d[0] * d[1], -d[1] * d[2], -d[2] * d[0]}; }

EdgeSecond edge_second(const BoxSplineHessian& h, const std::array<Bary, 3>& at, int k) {
    const auto difference = [&](int i) {
        const Bary &a = at[i], &b = at[next3(i)];
        return Bary{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    };
    const std::array<double, 3> weight = along_weights(difference(k));
    EdgeSecond out;
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        out.corner[i] = Vec3d(0);
        for (int e = 0; e < 3; ++e)
            if (weight[e] != 0) out.corner[i] += weight[e] * h.along(e, at[i]);
        largest = std::max(largest, squared(out.corner[i]));
    }
    for (int i = 0; i < 3; ++i) {
        const Bary d = difference(i);
        Vec3d control = 0.5 * (out.corner[i] + out.corner[next3(i)]);
        for (int e = 0; e < 3; ++e)
            if (weight[e] != 0) control -= (0.5 * weight[e] * d[e] * d[next3(e)]) * h.bend[e];
        largest = std::max(largest, squared(control));
        if (i == k) out.along_edge = control;
    }
    out.bound = std::sqrt(largest);
    return out;
}

}  // namespace

std::array<EdgeSecond, 3> edge_seconds(const BoxSplineHessian& h, const std::array<Bary, 3>& at) {
    if (const int p = red_edge(at); p >= 0) {
        const double size = red_size(at);
        return {edge_second_red(h, at, 0, p, size), edge_second_red(h, at, 1, next3(p), size),
                edge_second_red(h, at, 2, prev3(p), size)};
    }
    return {edge_second(h, at, 0), edge_second(h, at, 1), edge_second(h, at, 2)};
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
