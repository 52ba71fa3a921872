#include "tetrakis/eval/dual_patch.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

namespace {

/// Errors of interpolated values beside those of the points: what interpolation at three nodes makes of them in either
/// direction is at most 2.7 times as large on the cell, in both 7.3 times.
constexpr double k_spread = 8;

using Exponents = std::array<int, 3>;

constexpr std::array<Exponents, 6> k_quadratic = {
    {{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}}};
constexpr std::array<Exponents, 15> k_quartic = {{{4, 0, 0},
                                                  {3, 1, 0},
                                                  {3, 0, 1},
                                                  {2, 2, 0},
                                                  {2, 1, 1},
                                                  {2, 0, 2},
                                                  {1, 3, 0},
                                                  {1, 2, 1},
                                                  {1, 1, 2},
                                                  {1, 0, 3},
                                                  {0, 4, 0},
                                                  {0, 3, 1},
                                                  {0, 2, 2},
                                                  {0, 1, 3},
                                                  {0, 0, 4}}};

constexpr double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }
constexpr double choices(const Exponents& e) {
    return factorial(e[0] + e[1] + e[2]) / (factorial(e[0]) * factorial(e[1]) * factorial(e[2]));
}

/// The product of two quadratics' coefficients is one of a quartic's, with a weight.
struct Product {
    int into;
    double weight;
};
constexpr std::array<std::array<Product, 6>, 6> products() {
    std::array<std::array<Product, 6>, 6> table{};
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b) {
            Exponents sum{};
            for (std::size_t k = 0; k < 3; ++k) sum[k] = k_quadratic[a][k] + k_quadratic[b][k];
            int into = 0;
            while (k_quartic[static_cast<std::size_t>(into)] != sum) ++into;
            table[a][b] = {into, choices(k_quadratic[a]) * choices(k_quadratic[b]) / choices(sum)};
        }
    return table;
}
constexpr auto k_products = products();

/// Of the four nodes along a direction, those that a quadratic is found from. Where the surface ends at the lower side,
/// the first two of the others are near that one.
constexpr std::array<int, 3> k_nodes = {0, 1, 3}, k_nodes_from_end = {0, 2, 3};

/// Coefficients of the powers of s from the values at three nodes.
std::array<std::array<double, 3>, 3> to_powers(const std::array<double, 3>& node) {
    std::array<std::array<double, 3>, 3> rows{};
    for (std::size_t k = 0; k < 3; ++k) {
        const double a = node[(k + 1) % 3], b = node[(k + 2) % 3], scale = 1 / ((node[k] - a) * (node[k] - b));
        rows[0][k] = a * b * scale;
        rows[1][k] = -(a + b) * scale;
        rows[2][k] = scale;
    }
    return rows;
}

double unit(const VertexCell& cell) { return std::ldexp(1.0, -cell.level); }

}  // namespace

const std::array<std::array<int, 3>, DualPatch::k_coefficients> DualPatch::k_exponents = k_quartic;

Vec2d DualAxes::vertex_place(const VertexCell& cell) const {
    const double side = unit(cell);
    const std::uint32_t last = (1u << cell.level) - 1;
    const auto place = [&](std::uint32_t at, unsigned low, unsigned high) {
        if (at == 0 && (outer_ & low) != 0) return 0.0;
        if (at == last && (outer_ & high) != 0) return 1.0;
        return (at + 0.5) * side;
    };
    return {place(cell.at.x, 8u, 2u), place(cell.at.y, 1u, 4u)};
}

Vec2d corner_place(const VertexCell& cell, int corner) {
    return unit(cell) * Vec2d{cell.at.x + (corner == 1 || corner == 2 ? 1.0 : 0.0), cell.at.y + (corner >= 2 ? 1.0 : 0.0)};
}

Vec2d middle_place(const VertexCell& cell, int side) {
    return 0.5 * (corner_place(cell, side) + corner_place(cell, (side + 1) % 4));
}

DualBox box_of(const DualAxes& axes, const VertexCell& cell) {
    return {axes(corner_place(cell, 0)), axes(corner_place(cell, 2))};
}

DualPatch::DualPatch(const DualAxes& axes, const VertexCell& cell, std::span<const Vec3d> points) {
    constexpr std::uint32_t k_side = 1u << k_bits;
    const DualBox box = box_of(axes, cell);
    low_ = box.low;
    scale_ = 1.0 / (box.high - box.low);
    std::array<double, k_side> s{}, t{};
    for (std::uint32_t i = 0; i < k_side; ++i) {
        const Vec2d p = axes.vertex({cell.root,
                                     {(cell.at.x << k_bits) + i, (cell.at.y << k_bits) + i},
                                     static_cast<std::uint8_t>(cell.level + k_bits)});
        s[i] = (p.x - low_.x) * scale_.x;
        t[i] = (p.y - low_.y) * scale_.y;
    }
    const std::array<int, 3>& columns = s[0] == 0 ? k_nodes_from_end : k_nodes;
    const std::array<int, 3>& rows = t[0] == 0 ? k_nodes_from_end : k_nodes;
    const auto chosen = [](const std::array<double, k_side>& node, const std::array<int, 3>& which) {
        return std::array<double, 3>{node[static_cast<std::size_t>(which[0])], node[static_cast<std::size_t>(which[1])],
                                     node[static_cast<std::size_t>(which[2])]};
    };
    const auto in_s = to_powers(chosen(s, columns)), in_t = to_powers(chosen(t, rows));
    std::array<Vec3d, 9> by_rows{};  // powers of s, row by row
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < 3; ++c)
                by_rows[3 * r + i] += in_s[i][c] * points[static_cast<std::size_t>(rows[r] * 4 + columns[c])];
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t i = 0; i < 3; ++i) monomial_[3 * j + i] += in_t[j][r] * by_rows[3 * r + i];
    for (std::size_t r = 0; r < k_side; ++r)
        for (std::size_t c = 0; c < k_side; ++c)
            slack_ = std::max(slack_, glm::length(at(s[c], t[r]) - points[r * k_side + c]));
    slack_ *= k_spread;
}

Vec3d DualPatch::at(double s, double t) const {
    const auto row = [&](std::size_t j) {
        return monomial_[3 * j] + s * (monomial_[3 * j + 1] + s * monomial_[3 * j + 2]);
    };
    return row(0) + t * (row(1) + t * row(2));
}

DualPatch::Coefficients DualPatch::over(const std::array<Vec2d, 3>& triangle) const {
    // By powers of t, each a quadratic in s: both factors in Bernstein form over the triangle (polar forms), then their
    // products.
    std::array<Vec2d, 3> p;
    for (std::size_t k = 0; k < 3; ++k) p[k] = (triangle[k] - low_) * scale_;
    constexpr std::array<std::array<std::size_t, 2>, 6> k_pair = {{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
    std::array<std::array<Vec3d, 3>, 6> factor;  // per coefficient, by powers of t
    std::array<std::array<double, 3>, 6> power;
    for (std::size_t a = 0; a < 6; ++a) {
        const Vec2d &u = p[k_pair[a][0]], &v = p[k_pair[a][1]];
        const Vec2d mean = 0.5 * (u + v), product = u * v;
        for (std::size_t j = 0; j < 3; ++j)
            factor[a][j] = monomial_[3 * j] + mean.x * monomial_[3 * j + 1] + product.x * monomial_[3 * j + 2];
        power[a] = {1, mean.y, product.y};
    }
    Coefficients out{};
    for (std::size_t a = 0; a < 6; ++a)
        for (std::size_t b = 0; b < 6; ++b) {
            const auto [into, weight] = k_products[a][b];
            out[static_cast<std::size_t>(into)] +=
                weight * (power[b][0] * factor[a][0] + power[b][1] * factor[a][1] + power[b][2] * factor[a][2]);
        }
    return out;
}

}  // namespace tetrakis::detail
