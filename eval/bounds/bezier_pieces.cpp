#include "bezier_pieces.hpp"

#include "../patches/cell.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrakis::detail {

namespace {

constexpr double choose(int n, int k) { return k == 0 ? 1 : choose(n - 1, k - 1) * n / k; }

/// A tensor product's control point of degree 2 D is the mean of its polar form over all ways to give D of the 2 D
/// arguments to x and D to y. The way with exponents a for x and b for y counts for the control point with exponents
/// a + b.
struct Share {
    std::size_t into;
    double weight;
};
template <int D>
constexpr auto k_shares = [] {
    using Side = BezierTriangle<D>;
    std::array<std::array<Share, Side::k_count>, Side::k_count> table{};
    for (int aj = 0; aj <= D; ++aj)
        for (int ai = 0; ai + aj <= D; ++ai)
            for (int bj = 0; bj <= D; ++bj)
                for (int bi = 0; bi + bj <= D; ++bi) {
                    const int ah = D - ai - aj, bh = D - bi - bj;
                    table[Side::index(ai, aj)][Side::index(bi, bj)] = {
                        BezierTriangle<2 * D>::index(ai + bi, aj + bj),
                        choose(ah + bh, ah) * choose(ai + bi, ai) * choose(aj + bj, aj) / choose(2 * D, D)};
                }
    return table;
}();

/// Weights of a uniform B-spline's control points in its polar form.
Weights4 polar_weights(const std::array<double, 3>& at) { return cubic_polar(at[0], at[1], at[2]); }
std::array<double, 3> polar_weights(const std::array<double, 2>& at) {
    const auto [u, v] = at;
    return {(1 - u) * (1 - v) / 2, (1 - u) * (1 + v) / 2 + u * (2 - v) / 2, u * v / 2};
}

/// polar_weights() for each control point over a triangle whose corners have the coordinates `at` on one axis.
template <int D>
auto weights_over(const std::array<double, 3>& at) {
    std::array<std::array<double, D + 1>, BezierTriangle<D>::k_count> weights;
    for (int j = 0; j <= D; ++j)
        for (int i = 0; i + j <= D; ++i) {
            std::array<double, D> arguments;
            for (int k = 0; k < D; ++k)
                arguments[static_cast<std::size_t>(k)] = k < i ? at[1] : k < i + j ? at[2] : at[0];
            weights[BezierTriangle<D>::index(i, j)] = polar_weights(arguments);
        }
    return weights;
}

/// Weights of a net's points, row by row, in the control points over a triangle.
template <int D>
using TensorWeights = std::array<typename BezierTriangle<2 * D>::Coordinates, (D + 1) * (D + 1)>;

template <int D>
TensorWeights<D> tensor_weights(const std::array<Vec2d, 3>& triangle) {
    const auto x = weights_over<D>({triangle[0].x, triangle[1].x, triangle[2].x});
    const auto y = weights_over<D>({triangle[0].y, triangle[1].y, triangle[2].y});
    TensorWeights<D> weights{};
    for (std::size_t a = 0; a < BezierTriangle<D>::k_count; ++a)
        for (std::size_t b = 0; b < BezierTriangle<D>::k_count; ++b) {
            const auto& share = k_shares<D>[a][b];
            for (std::size_t r = 0; r <= D; ++r)
                for (std::size_t c = 0; c <= D; ++c)
                    weights[(D + 1) * r + c][share.into] += share.weight * y[b][r] * x[a][c];
        }
    return weights;
}

/// The same for a regular triangle of Loop.
using QuarticWeights = std::array<BezierTriangle<4>::Coordinates, 12>;

QuarticWeights quartic_weights(const std::array<Vec2d, 3>& triangle) {
    QuarticWeights weights;
    for (std::size_t p = 0; p < weights.size(); ++p) {
        Net12 net{};
        net[p].x = 1;
        weights[p] = box_spline_triangle(net).over({bary(triangle[0]), bary(triangle[1]), bary(triangle[2])}).c[0];
    }
    return weights;
}

/// The weights for a triangle, from the thread's cache. The reference is valid until the next call.
template <auto Compute>
const auto& known_weights(const std::array<Vec2d, 3>& triangle) {
    constexpr std::size_t k_most = 128;  // ordinary models have ten kinds, those with semi-sharp creases a hundred
    thread_local std::vector<std::array<Vec2d, 3>> triangles;
    thread_local std::vector<decltype(Compute(triangle))> weights;
    const auto known = static_cast<std::size_t>(std::ranges::find(triangles, triangle) - triangles.begin());
    if (known < triangles.size()) return weights[known];
    if (weights.size() == k_most) triangles.clear(), weights.clear();
    weights.push_back(Compute(triangle));
    triangles.push_back(triangle);
    return weights.back();
}

}  // namespace

BezierTriangle<6> polynomial_over(const Net16& net, const std::array<Vec2d, 3>& triangle) {
    std::array<Vec3d, 16> points;
    for (std::size_t p = 0; p < points.size(); ++p) points[p] = {net.c[0][p], net.c[1][p], net.c[2][p]};
    return combined<6>(points, known_weights<tensor_weights<3>>(triangle));
}
BezierTriangle<4> polynomial_over(const Net12& net, const std::array<Vec2d, 3>& triangle) {
    if (is_common(triangle)) return combined<4>(net, known_weights<quartic_weights>(triangle));
    return box_spline_triangle(net).over({bary(triangle[0]), bary(triangle[1]), bary(triangle[2])});
}
BezierTriangle<4> polynomial_over(const Net9& net, const std::array<Vec2d, 3>& triangle) {
    return combined<4>(net, tensor_weights<2>(triangle));
}

BezierTriangle<2> four_direction_over(const Net9& net, int side, const std::array<Vec2d, 3>& triangle) {
    // Around the cell counter-clockwise, from the corner where the side starts.
    constexpr std::array<std::size_t, 8> k_around = {0, 1, 2, 5, 8, 7, 6, 3};
    const auto beside = [&](int i) { return net[k_around[static_cast<std::size_t>(i) % 8]]; };
    const int s = 2 * side;
    const Vec3d &own = net[4], before = beside(s + 7), next = beside(s + 1), after = beside(s + 3);
    BezierTriangle<2> quarter;  // its corners: the cell's centre, the side's start and end
    quarter.set(0, 0, 0.5 * own + 0.125 * (net[1] + net[3] + net[5] + net[7]));
    quarter.set(1, 0, 0.25 * (2.0 * own + before + next));
    quarter.set(0, 1, 0.25 * (2.0 * own + next + after));
    quarter.set(2, 0, 0.25 * (own + before + beside(s) + next));
    quarter.set(1, 1, 0.5 * (own + next));
    quarter.set(0, 2, 0.25 * (own + next + beside(s + 2) + after));
    const auto from_centre = [](int c) { return cell_corner(c % 4, 4) - Vec2d(0.5); };
    const Vec2d start = from_centre(side), end = from_centre(side + 1);  // perpendicular
    std::array<std::array<double, 3>, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec2d p = triangle[k] - Vec2d(0.5);
        at[k][1] = 2 * glm::dot(p, start);
        at[k][2] = 2 * glm::dot(p, end);
        at[k][0] = 1 - at[k][1] - at[k][2];
    }
    return quarter.over(at);
}

}  // namespace tetrakis::detail
