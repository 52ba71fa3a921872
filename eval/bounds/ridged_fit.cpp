#include "ridged_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::size_t k_terms = RidgedFit::k_terms, k_points = DualPatch::k_points, k_in_row = 4;
using Square = std::array<std::array<double, k_terms>, k_terms>;
using Values = std::array<std::array<double, k_terms>, k_points>;  // of each term at each point
using Rows = RidgedFit::Rows;

std::array<double, k_terms> terms(double s, double t) {
    const double left = std::max(t - s, 0.0), right = std::max(s + t - 1, 0.0);
    return {1, s, s * s, t, s * t, t * t, left * left, right * right};
}

/// Gauss-Jordan with pivots.
Square inverse(Square m) {
    Square out{};
    for (std::size_t i = 0; i < k_terms; ++i) out[i][i] = 1;
    for (std::size_t c = 0; c < k_terms; ++c) {
        std::size_t pivot = c;
        for (std::size_t r = c; r < k_terms; ++r)
            if (std::abs(m[r][c]) > std::abs(m[pivot][c])) pivot = r;
        std::swap(m[c], m[pivot]);
        std::swap(out[c], out[pivot]);
        const double scale = 1 / m[c][c];
        for (std::size_t k = 0; k < k_terms; ++k) m[c][k] *= scale, out[c][k] *= scale;
        for (std::size_t r = 0; r < k_terms; ++r) {
            if (r == c) continue;
            const double factor = m[r][c];
            for (std::size_t k = 0; k < k_terms; ++k) m[r][k] -= factor * m[c][k], out[r][k] -= factor * out[c][k];
        }
    }
    return out;
}

/// P (2 I - A P): squares the error of an approximate left inverse P of A, as that by normal equations is.
Rows improved(const Rows& p, const Values& a) {
    Square rest{};  // 2 I - P A
    for (std::size_t i = 0; i < k_terms; ++i)
        for (std::size_t j = 0; j < k_terms; ++j) {
            rest[i][j] = i == j ? 2 : 0;
            for (std::size_t k = 0; k < k_points; ++k) rest[i][j] -= p[i][k] * a[k][j];
        }
    Rows out{};
    for (std::size_t i = 0; i < k_terms; ++i)
        for (std::size_t k = 0; k < k_points; ++k)
            for (std::size_t j = 0; j < k_terms; ++j) out[i][k] += rest[i][j] * p[j][k];
    return out;
}

Rows fit(int columns, int rows) {
    const auto node = [](int ends, std::size_t i) {
        if (i == 0 && (ends & 1) != 0) return 0.0;
        if (i + 1 == k_in_row && (ends & 2) != 0) return 1.0;
        return (static_cast<double>(i) + 0.5) / k_in_row;
    };
    Values a{};
    for (std::size_t k = 0; k < k_points; ++k) a[k] = terms(node(columns, k % k_in_row), node(rows, k / k_in_row));
    Square normal{};
    for (std::size_t i = 0; i < k_terms; ++i)
        for (std::size_t j = 0; j < k_terms; ++j)
            for (std::size_t k = 0; k < k_points; ++k) normal[i][j] += a[k][i] * a[k][j];
    const Square inverted = inverse(normal);
    Rows out{};
    for (std::size_t i = 0; i < k_terms; ++i)
        for (std::size_t k = 0; k < k_points; ++k)
            for (std::size_t j = 0; j < k_terms; ++j) out[i][k] += inverted[i][j] * a[k][j];
    return improved(improved(out, a), a);
}

/// Whether the first node is at 0 (1) and the last at 1 (2).
int ends(std::span<const double> node) { return (node.front() == 0 ? 1 : 0) + (node.back() == 1 ? 2 : 0); }

}  // namespace

const RidgedFit::Rows& RidgedFit::of(std::span<const double> s, std::span<const double> t) {
    static const std::array<Rows, 16> table = [] {
        std::array<Rows, 16> all{};
        for (int columns = 0; columns < 4; ++columns)
            for (int rows = 0; rows < 4; ++rows) all[static_cast<std::size_t>(4 * rows + columns)] = fit(columns, rows);
        return all;
    }();
    return table[static_cast<std::size_t>(4 * ends(t) + ends(s))];
}

}  // namespace tetrakis::detail
