#include "box_spline.hpp"

#include "../triangles/avx2.hpp"

namespace tetrakis::detail {

namespace {

using Quartic = BezierTriangle<4>;

// Bernstein coefficients of the basis functions, times 12; u, v, w are exponents of the triangle's corners. single():
// the basis function's point is a neighbour of corner u alone, on the side of v.
constexpr double single(int u, int v) { return u == 4 ? 1 : u == 3 && v == 1 ? 0.5 : 0; }
// The basis function's point lies across the edge of corners u and v.
constexpr double across(int u, int v, int w) {
    return w == 0 ? (u == 2 ? 2 : u == 1 || v == 1 ? 1.5 : 1) : w == 1 ? 0.5 : 0;
}
// The basis function's point is corner u; symmetric in v and w.
constexpr double corner(int u, int v, int w) {
    if (u >= 3) return 6;
    if (u == 2) return v == 1 ? 5 : 4;
    if (u == 1) return v == 0 || w == 0 ? 2 : 3;
    return across(v, w, 0);
}

constexpr double k_scale = 1.0 / 12;

/// k_rows[i][k]: weight of net point k in Bezier control point i; k_columns is the transpose.
constexpr auto k_rows = [] {
    std::array<std::array<double, 12>, Quartic::k_count> table{};
    for (int j = 0; j <= 4; ++j)
        for (int i = 0; i + j <= 4; ++i) {
            const int u = 4 - i - j, v = i, w = j;
            table[Quartic::index(i, j)] = {corner(u, v, w), corner(v, w, u), corner(w, u, v), across(w, u, v),
                                           single(u, w),    single(u, v),    across(u, v, w), single(v, u),
                                           single(v, w),    across(v, w, u), single(w, v),    single(w, u)};
            for (double& weight : table[Quartic::index(i, j)]) weight *= k_scale;
        }
    return table;
}();
constexpr auto k_columns = [] {
    std::array<Quartic::Coordinates, 12> table{};
    for (std::size_t k = 0; k < 12; ++k)
        for (std::size_t i = 0; i < Quartic::k_count; ++i) table[k][i] = k_rows[i][k];
    return table;
}();

}  // namespace

BezierTriangle<4> box_spline_triangle(const Net12& net) { return combined<4>(net, k_columns); }

TETRAKIS_FOR_AVX2_TOO
Vec3d box_spline_position(const Net12& net, const Bary& at) {
    const auto [u, v, w] = at;
    const double u2 = u * u, v2 = v * v, w2 = w * w;
    const std::array<double, Quartic::k_count> bernstein = {
        u2 * u2,         4 * u2 * u * v,  6 * u2 * v2,     4 * u * v2 * v, v2 * v2,
        4 * u2 * u * w,  12 * u2 * v * w, 12 * u * v2 * w, 4 * v2 * v * w, 6 * u2 * w2,
        12 * u * v * w2, 6 * v2 * w2,     4 * u * w2 * w,  4 * v * w2 * w, w2 * w2};
    std::array<double, 12> weights{};
    for (std::size_t i = 0; i < Quartic::k_count; ++i)
        for (std::size_t k = 0; k < 12; ++k) weights[k] += bernstein[i] * k_rows[i][k];
    Vec3d sum = weights[0] * net[0];
    for (std::size_t k = 1; k < 12; ++k) sum += weights[k] * net[k];
    return sum;
}

Vec3d box_spline_corner(const Net12& net, int corner) {
    constexpr int ring[3][6] = {{1, 2, 3, 4, 5, 6}, {0, 2, 6, 7, 8, 9}, {0, 1, 3, 9, 10, 11}};
    const int* r = ring[corner];
    return 0.5 * net[static_cast<std::size_t>(corner)] +
           k_scale * ((net[r[0]] + net[r[1]]) + (net[r[2]] + net[r[3]]) + (net[r[4]] + net[r[5]]));
}

}  // namespace tetrakis::detail
