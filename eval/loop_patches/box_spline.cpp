#include "box_spline.hpp"

namespace tetrakis::detail {

namespace {

using Quartic = BezierTriangle<4>;

// Bernstein coefficients of the basis functions by symmetry classes, 12 times their value; u, v, w are the exponents of
// the corners they are near. A point beside one corner u, on the side of v.
constexpr double single(int u, int v) { return u == 4 ? 1 : u == 3 && v == 1 ? 0.5 : 0; }
// A point across the edge of u and v.
constexpr double across(int u, int v, int w) {
    return w == 0 ? (u == 2 ? 2 : u == 1 || v == 1 ? 1.5 : 1) : w == 1 ? 0.5 : 0;
}
// The corner u itself; symmetric in v and w.
constexpr double corner(int u, int v, int w) {
    if (u >= 3) return 6;
    if (u == 2) return v == 1 ? 5 : 4;
    if (u == 1) return v == 0 || w == 0 ? 2 : 3;
    return across(v, w, 0);
}

constexpr double k_scale = 1.0 / 12;

/// By control point, and the same by point of the net.
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
    std::array<std::array<double, Quartic::k_count>, 12> table{};
    for (std::size_t k = 0; k < 12; ++k)
        for (std::size_t i = 0; i < Quartic::k_count; ++i) table[k][i] = k_rows[i][k];
    return table;
}();

/// Weights of a polynomial's control points.
template <int Degree>
using Weights = std::array<double, BezierTriangle<Degree>::k_count>;

/// In the derivative towards a corner, from those of the derivative's own control points.
template <int Degree>
Weights<Degree + 1> derivative(const Weights<Degree>& of, int corner) {
    Weights<Degree + 1> weights{};
    for (int j = 0; j <= Degree; ++j)
        for (int i = 0; i + j <= Degree; ++i) {
            const double weight = (Degree + 1) * of[BezierTriangle<Degree>::index(i, j)];
            weights[BezierTriangle<Degree + 1>::index(i + (corner == 1), j + (corner == 2))] += weight;
            weights[BezierTriangle<Degree + 1>::index(i, j)] -= weight;
        }
    return weights;
}

/// The combination of the patch's control points.
TETRAKIS_FOR_AVX2_TOO
Vec3d combine(const Net12& net, const Weights<4>& of_points) {
    std::array<double, 12> weights{};
    for (std::size_t i = 0; i < of_points.size(); ++i)
        for (std::size_t k = 0; k < 12; ++k) weights[k] += of_points[i] * k_rows[i][k];
    Vec3d sum = weights[0] * net[0];
    for (std::size_t k = 1; k < 12; ++k) sum += weights[k] * net[k];
    return sum;
}

}  // namespace

TETRAKIS_FOR_AVX2_TOO
BezierTriangle<4> box_spline_triangle(const Net12& net) {
    std::array<std::array<double, Quartic::k_count>, 3> sum{};
    for (std::size_t k = 0; k < 12; ++k)
        for (int c = 0; c < 3; ++c)
            for (std::size_t i = 0; i < Quartic::k_count; ++i)
                sum[static_cast<std::size_t>(c)][i] += k_columns[k][i] * net[k][c];
    Quartic result;
    for (std::size_t i = 0; i < Quartic::k_count; ++i) result.point[i] = {sum[0][i], sum[1][i], sum[2][i]};
    return result;
}

Vec3d box_spline_position(const Net12& net, const Bary& at) {
    const auto [u, v, w] = at;
    const double u2 = u * u, v2 = v * v, w2 = w * w;
    return combine(net, {u2 * u2, 4 * u2 * u * v, 6 * u2 * v2, 4 * u * v2 * v, v2 * v2, 4 * u2 * u * w, 12 * u2 * v * w,
                         12 * u * v2 * w, 4 * v2 * v * w, 6 * u2 * w2, 12 * u * v * w2, 6 * v2 * w2, 4 * u * w2 * w,
                         4 * v * w2 * w, w2 * w2});
}

Vec3d box_spline_corner(const Net12& net, int corner) {
    constexpr int ring[3][6] = {{1, 2, 3, 4, 5, 6}, {0, 2, 6, 7, 8, 9}, {0, 1, 3, 9, 10, 11}};
    const int* r = ring[corner];
    return 0.5 * net[static_cast<std::size_t>(corner)] +
           k_scale * ((net[r[0]] + net[r[1]]) + (net[r[2]] + net[r[3]]) + (net[r[4]] + net[r[5]]));
}

BoxSplineTangents box_spline_tangents(const Net12& net, const Bary& at) {
    const auto [u, v, w] = at;
    const Weights<3> cubic = {u * u * u,     3 * u * u * v, 3 * u * v * v, v * v * v,     3 * u * u * w,
                              6 * u * v * w, 3 * v * v * w, 3 * u * w * w, 3 * v * w * w, w * w * w};
    return {combine(net, derivative<3>(cubic, 1)), combine(net, derivative<3>(cubic, 2))};
}

BoxSplineBends box_spline_bends(const Net12& net, const Bary& at) {
    const auto [u, v, w] = at;
    const Weights<2> square = {u * u, 2 * u * v, v * v, 2 * u * w, 2 * v * w, w * w};
    const auto by_x = derivative<2>(square, 1), by_y = derivative<2>(square, 2);
    return {combine(net, derivative<3>(by_x, 1)), combine(net, derivative<3>(by_x, 2)),
            combine(net, derivative<3>(by_y, 2))};
}

}  // namespace tetrakis::detail
