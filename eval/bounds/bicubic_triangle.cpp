#include "bicubic_triangle.hpp"

namespace tetrakis::detail {

namespace {

using Cubic = BezierTriangle<3>;
using Sextic = BezierTriangle<6>;

constexpr double choose(int n, int k) { return k == 0 ? 1 : choose(n - 1, k - 1) * n / k; }

/// A control point of degree 6 is the mean of the patch's polar form over all ways to give three of its six arguments
/// to x and three to y. The one with exponents a for x and b for y counts for the control point with exponents a + b.
struct Share {
    std::size_t into;
    double weight;
};
constexpr auto k_shares = [] {
    std::array<std::array<Share, Cubic::k_count>, Cubic::k_count> table{};
    for (int aj = 0; aj <= 3; ++aj)
        for (int ai = 0; ai + aj <= 3; ++ai)
            for (int bj = 0; bj <= 3; ++bj)
                for (int bi = 0; bi + bj <= 3; ++bi) {
                    const int ah = 3 - ai - aj, bh = 3 - bi - bj;
                    table[Cubic::index(ai, aj)][Cubic::index(bi, bj)] = {
                        Sextic::index(ai + bi, aj + bj),
                        choose(ah + bh, ah) * choose(ai + bi, ai) * choose(aj + bj, aj) / choose(6, 3)};
                }
    return table;
}();

/// Weights of a uniform cubic B-spline's control points in its polar form at
/// (u, v, w).
Weights4 polar_weights(double u, double v, double w) {
    // De Boor's algorithm, backwards.
    const double e0 = 1 - w, e1 = w;
    const double d0 = e0 * (1 - v) / 2, d1 = e0 * (1 + v) / 2 + e1 * (2 - v) / 2, d2 = e1 * v / 2;
    return {d0 * (1 - u) / 3, (d0 * (2 + u) + d1 * (2 - u)) / 3, (d1 * (1 + u) + d2 * (3 - u)) / 3, d2 * u / 3};
}

std::array<Weights4, Cubic::k_count> cubic_weights(const std::array<double, 3>& at) {
    std::array<Weights4, Cubic::k_count> weights;
    for (int j = 0; j <= 3; ++j)
        for (int i = 0; i + j <= 3; ++i) {
            const auto argument = [&](int k) { return k < i ? at[1] : k < i + j ? at[2] : at[0]; };
            weights[Cubic::index(i, j)] = polar_weights(argument(0), argument(1), argument(2));
        }
    return weights;
}

}  // namespace

SexticWeights sextic_weights(const std::array<Vec2d, 3>& triangle) {
    const auto x = cubic_weights({triangle[0].x, triangle[1].x, triangle[2].x});
    const auto y = cubic_weights({triangle[0].y, triangle[1].y, triangle[2].y});
    SexticWeights weights{};
    for (std::size_t a = 0; a < Cubic::k_count; ++a)
        for (std::size_t b = 0; b < Cubic::k_count; ++b) {
            const Share& share = k_shares[a][b];
            for (std::size_t r = 0; r < 4; ++r)
                for (std::size_t c = 0; c < 4; ++c) weights[4 * r + c][share.into] += share.weight * y[b][r] * x[a][c];
        }
    return weights;
}

BezierTriangle<6> bicubic_over(const Net16& net, const SexticWeights& weights) {
    std::array<std::array<double, Sextic::k_count>, 3> sum{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t p = 0; p < weights.size(); ++p)
            for (std::size_t i = 0; i < Sextic::k_count; ++i) sum[k][i] += net.c[k][p] * weights[p][i];
    Sextic result;
    for (std::size_t i = 0; i < Sextic::k_count; ++i) result.point[i] = {sum[0][i], sum[1][i], sum[2][i]};
    return result;
}

}  // namespace tetrakis::detail
