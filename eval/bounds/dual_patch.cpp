#include "dual_patch.hpp"

#include "ridged_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace tetrakis::detail {

namespace {

/// Errors of interpolated values beside those of the points: interpolation at three nodes makes them at most 4.2 times
/// as large in either direction on the cell, and so 17.7 times; a fit of four pieces less.
constexpr double k_spread = 18;

constexpr std::size_t k_side = std::size_t{1} << DualPatch::k_bits;

using Exponents = std::array<int, 3>;

constexpr std::array<Exponents, 6> k_quadratic = {{{2, 0, 0}, {1, 1, 0}, {1, 0, 1}, {0, 2, 0}, {0, 1, 1}, {0, 0, 2}}};
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
constexpr std::array<std::size_t, 3> k_nodes = {0, 1, 3}, k_nodes_from_end = {0, 2, 3};

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
    return unit(cell) *
           Vec2d{cell.at.x + (corner == 1 || corner == 2 ? 1.0 : 0.0), cell.at.y + (corner >= 2 ? 1.0 : 0.0)};
}

Vec2d middle_place(const VertexCell& cell, int side) {
    return 0.5 * (corner_place(cell, side) + corner_place(cell, (side + 1) % 4));
}

DualBox box_of(const DualAxes& axes, const VertexCell& cell) {
    return {axes(corner_place(cell, 0)), axes(corner_place(cell, 2))};
}

FlatMap::FlatMap(const std::array<Vec2d, 3>& at, const std::array<Vec3d, 3>& to) {
    const Vec2d u = at[1] - at[0], v = at[2] - at[0];
    const double area = u.x * v.y - u.y * v.x;
    const Vec3d a = to[1] - to[0], b = to[2] - to[0];
    by_x = (v.y * a - u.y * b) / area;
    by_y = (u.x * b - v.x * a) / area;
    constant = to[0] - at[0].x * by_x - at[0].y * by_y;
}

double DualPart::difference(const FlatMap& flat) const {
    Monomials rest = monomials_;
    rest[0] -= flat(bend_[0]);
    for (std::size_t i = 1; i < 3; ++i) {
        rest[i] -= bend_[i].x * flat.by_x;
        rest[3 * i] -= bend_[i].y * flat.by_y;
    }
    double squared = 0;
    for_each_triangle([&](const std::array<Vec2d, 3>& triangle) {
        for (const Vec3d& off : coefficients(rest, triangle)) squared = std::max(squared, glm::dot(off, off));
    });
    return std::sqrt(squared) + slack_;
}

DualPart::Coefficients DualPart::coefficients(const Monomials& monomials, const std::array<Vec2d, 3>& p) {
    // By powers of t, each a quadratic in s: both factors in Bernstein form over the triangle (polar forms), then their
    // products.
    constexpr std::array<std::array<std::size_t, 2>, 6> k_pair = {{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
    std::array<std::array<Vec3d, 3>, 6> factor;  // per coefficient, by powers of t
    std::array<std::array<double, 3>, 6> power;
    for (std::size_t a = 0; a < 6; ++a) {
        const Vec2d &u = p[k_pair[a][0]], &v = p[k_pair[a][1]];
        const Vec2d mean = 0.5 * (u + v), product = u * v;
        for (std::size_t j = 0; j < 3; ++j)
            factor[a][j] = monomials[3 * j] + mean.x * monomials[3 * j + 1] + product.x * monomials[3 * j + 2];
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

DualPatch::DualPatch(DualPieces pieces, DualFrame frame, const DualAxes& axes, const VertexCell& cell,
                     std::span<const Vec3d> points)
    : ridged_(pieces == DualPieces::four), frame_(ridged_ ? DualFrame::cell : frame) {
    // s and t are the root's coordinates (biquadratic) or lengths on the cell, from 0 to 1.
    const Vec2d low = axes(corner_place(cell, 0)), high = axes(corner_place(cell, 2));
    bend_ = {low, high - low, Vec2d{0}};
    const bool on_cell = frame_ == DualFrame::cell;
    if (on_cell) {
        const Vec2d middle = axes(0.5 * (corner_place(cell, 0) + corner_place(cell, 2)));
        bend_ = {low, 4.0 * middle - 3.0 * low - high, 2.0 * (low + high - 2.0 * middle)};
    }
    std::array<double, k_side> s{}, t{};
    for (std::uint32_t i = 0; i < k_side; ++i) {
        const VertexCell below{cell.root,
                               {(cell.at.x << k_bits) + i, (cell.at.y << k_bits) + i},
                               static_cast<std::uint8_t>(cell.level + k_bits)};
        const Vec2d p = on_cell ? (axes.vertex_place(below) - corner_place(cell, 0)) / unit(cell)
                                : (axes.vertex(below) - low) / bend_[1];
        s[i] = p.x;
        t[i] = p.y;
    }
    if (ridged_)
        fit_four(s, t, points);
    else
        fit_biquadratic(s, t, points);
    for (std::size_t r = 0; r < k_side; ++r)
        for (std::size_t c = 0; c < k_side; ++c)
            slack_ = std::max(slack_, glm::length(at(s[c], t[r]) - points[r * k_side + c]));
    slack_ *= k_spread;
}

void DualPatch::fit_biquadratic(std::span<const double> s, std::span<const double> t, std::span<const Vec3d> points) {
    const std::array<std::size_t, 3>& columns = s[0] == 0 ? k_nodes_from_end : k_nodes;
    const std::array<std::size_t, 3>& rows = t[0] == 0 ? k_nodes_from_end : k_nodes;
    const auto in_s = to_powers({s[columns[0]], s[columns[1]], s[columns[2]]});
    const auto in_t = to_powers({t[rows[0]], t[rows[1]], t[rows[2]]});
    std::array<Vec3d, 9> by_rows{};  // powers of s, row by row
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < 3; ++c)
                by_rows[3 * r + i] += in_s[i][c] * points[rows[r] * k_side + columns[c]];
    for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t i = 0; i < 3; ++i) monomials_[3 * j + i] += in_t[j][r] * by_rows[3 * r + i];
}

void DualPatch::fit_four(std::span<const double> s, std::span<const double> t, std::span<const Vec3d> points) {
    const RidgedFit::Rows& rows = RidgedFit::of(s, t);
    constexpr std::array<std::size_t, 6> k_place = {0, 1, 2, 3, 4, 6};  // 1, s, s^2, t, s t, t^2
    for (std::size_t i = 0; i < RidgedFit::k_terms; ++i) {
        Vec3d sum(0);
        for (std::size_t p = 0; p < k_points; ++p) sum += rows[i][p] * points[p];
        (i < k_place.size() ? monomials_[k_place[i]] : ridge_[i - k_place.size()]) = sum;
    }
}

Vec3d DualPatch::at(double s, double t) const {
    const auto row = [&](std::size_t j) {
        return monomials_[3 * j] + s * (monomials_[3 * j + 1] + s * monomials_[3 * j + 2]);
    };
    const double left = std::max(t - s, 0.0), right = std::max(s + t - 1, 0.0);
    return row(0) + t * (row(1) + t * row(2)) + left * left * ridge_[0] + right * right * ridge_[1];
}

DualPart::Monomials DualPatch::beside(int side) const {
    DualPart::Monomials m = monomials_;
    if (side >= 2) {  // above the first diagonal: (t - s)^2
        m[2] += ridge_[0];
        m[4] -= 2.0 * ridge_[0];
        m[6] += ridge_[0];
    }
    if (side == 1 || side == 2) {  // above the other: (s + t - 1)^2
        m[0] += ridge_[1];
        m[1] -= 2.0 * ridge_[1];
        m[2] += ridge_[1];
        m[3] -= 2.0 * ridge_[1];
        m[4] += 2.0 * ridge_[1];
        m[6] += ridge_[1];
    }
    return m;
}

ShortPolygon DualPatch::beside(const ShortPolygon& polygon, int side) {
    const double left = side >= 2 ? 1 : -1, right = side == 1 || side == 2 ? 1 : -1;
    return polygon.beyond({-left, left}, 0).beyond({right, right}, right);
}

ShortPolygon DualPatch::to_cell(const ShortPolygon& polygon) const {
    ShortPolygon in_cell;
    for (std::size_t i = 0; i < polygon.size(); ++i) in_cell.add((polygon[i] - bend_[0]) / bend_[1]);
    return in_cell;
}

ShortPolygon DualPatch::straightened(const DualAxes& axes, const VertexCell& cell, const ShortPolygon& polygon) {
    // Lines of the root's coordinates are bent on the cell. With one of them the square of a length y, they are
    // parabolas, which lie in the triangles of their ends and the point where the tangents there meet; with two, they
    // rise or fall all the way, so that all is in the box around the ends.
    const bool bent_x = axes.is_bent_along(0), bent_y = axes.is_bent_along(1);
    std::vector<Vec2d> points;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec2d a = axes.place(polygon[i]), b = axes.place(polygon[(i + 1) % polygon.size()]);
        points.push_back(a);
        const Vec2d from = axes.from_end(a), to = axes.from_end(b), sum = from + to;
        Vec2d meet = 0.5 * (a + b);
        if (bent_y && sum.y > 0) meet.x = a.x + from.y / sum.y * (b.x - a.x);
        if (bent_x && sum.x > 0) meet.y = a.y + from.x / sum.x * (b.y - a.y);
        if (bent_x != bent_y) points.push_back(meet);
        if (bent_x && bent_y) {
            points.emplace_back(a.x, b.y);
            points.emplace_back(b.x, a.y);
        }
    }
    const double side = unit(cell);
    const Vec2d low = corner_place(cell, 0);
    for (Vec2d& p : points) p = (p - low) / side;
    return bent_x || bent_y ? ShortPolygon::around(std::move(points)) : ShortPolygon(points);
}

}  // namespace tetrakis::detail
