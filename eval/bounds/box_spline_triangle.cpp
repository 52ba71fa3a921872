#include "box_spline_triangle.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

namespace {

using Quartic = BezierTriangle<4>;

// Bernstein coefficients of the basis functions by symmetry classes (see box_spline.cpp), 12 times their value; u, v, w
// are the exponents of the corners they are near.
constexpr double single(int u, int v) { return u == 4 ? 1 : u == 3 && v == 1 ? 0.5 : 0; }
constexpr double across(int u, int v, int w) {
    return w == 0 ? (u == 2 ? 2 : u == 1 || v == 1 ? 1.5 : 1) : w == 1 ? 0.5 : 0;
}
constexpr double corner(int u, int v, int w) {
    if (u >= 3) return 6;
    if (u == 2) return v == 1 ? 5 : 4;
    if (u == 1) return v == 0 || w == 0 ? 2 : 3;
    return across(v, w, 0);
}

constexpr auto k_weights = [] {
    std::array<std::array<double, 12>, Quartic::k_count> table{};
    for (int j = 0; j <= 4; ++j)
        for (int i = 0; i + j <= 4; ++i) {
            const int u = 4 - i - j, v = i, w = j;
            auto& row = table[Quartic::index(i, j)];
            row = {corner(u, v, w), corner(v, w, u), corner(w, u, v), across(w, u, v), single(u, w), single(u, v),
                   across(u, v, w), single(v, u),    single(v, w),    across(v, w, u), single(w, v), single(w, u)};
            for (double& weight : row) weight /= 12;
        }
    return table;
}();

}  // namespace

BezierTriangle<4> box_spline_triangle(const Net12& net) {
    Quartic result;
    for (std::size_t i = 0; i < Quartic::k_count; ++i) {
        Vec3d sum(0);
        for (std::size_t k = 0; k < 12; ++k) sum += k_weights[i][k] * net[k];
        result.point[i] = sum;
    }
    return result;
}

double linear_deviation(const BezierTriangle<4>& patch) {
    // The line through a point parallel to one side ends on the other two. Where second derivatives along all three are
    // at most m, the point is within m / 6 of L. They are 12 times the second differences of control points.
    double squared = 0;
    for (int j = 0; j <= 2; ++j)
        for (int i = 0; i + j <= 2; ++i) {
            const auto at = [&](int a, int b) { return patch.point[Quartic::index(i + a, j + b)]; };
            for (const Vec3d& d : {at(0, 0) - 2.0 * at(1, 0) + at(2, 0), at(2, 0) - 2.0 * at(1, 1) + at(0, 2),
                                   at(0, 2) - 2.0 * at(0, 1) + at(0, 0)})
                squared = std::max(squared, glm::dot(d, d));
        }
    return 2 * std::sqrt(squared);
}

}  // namespace tetrakis::detail
