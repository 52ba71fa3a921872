#include "../../eval/bounds/bezier_pieces.hpp"

#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

using namespace tetrakis;
using namespace tetrakis::detail;

namespace {

constexpr double factorial(int n) { return n < 2 ? 1 : n * factorial(n - 1); }

template <int Degree>
Vec3d value(const BezierTriangle<Degree>& patch, const Bary& b) {
    Vec3d sum(0);
    for (int j = 0; j <= Degree; ++j)
        for (int i = 0; i + j <= Degree; ++i) {
            const int h = Degree - i - j;
            sum += factorial(Degree) / (factorial(h) * factorial(i) * factorial(j)) * std::pow(b[0], h) *
                   std::pow(b[1], i) * std::pow(b[2], j) * patch.point[patch.index(i, j)];
        }
    return sum;
}

/// Calls check(patch, corners) for a patch over a triangle and for both halves of it.
template <int Degree, class Corner, class Check>
void with_halves(const BezierTriangle<Degree>& patch, const std::array<Corner, 3>& at, const Corner& middle,
                 Check&& check) {
    check(patch, at);
    const auto [first, second] = patch.halves();
    check(first, std::array<Corner, 3>{at[2], at[0], middle});
    check(second, std::array<Corner, 3>{at[1], at[2], middle});
}

Bary random_bary(test::Random& random) {
    const double b0 = random.uniform(0, 1), b1 = random.uniform(0, 1 - b0);
    return {b0, b1, 1 - b0 - b1};
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("bicubic patches over triangles in Bernstein-Bezier form, and their halves") {
    test::Random random(1);
    Net16 net;
    for (auto& row : net.c)
        for (double& x : row) x = random.uniform(-1, 1);
    for (int round = 0; round < 20; ++round) {
        std::array<Vec2d, 3> at;
        for (Vec2d& p : at) p = {random.uniform(0, 1), random.uniform(0, 1)};
        with_halves(bicubic_over(net, sextic_weights(at)), at, Vec2d(0.5 * (at[0] + at[1])),
                    [&](const BezierTriangle<6>& patch, const std::array<Vec2d, 3>& corners) {
                        const Bary b = random_bary(random);
                        const Vec2d p = b[0] * corners[0] + b[1] * corners[1] + b[2] * corners[2];
                        const Vec3d expected = combine(net, cubic_basis(p.x), cubic_basis(p.y));
                        CHECK(glm::length(value(patch, b) - expected) < 1e-14);
                    });
    }
}

TEST_CASE("box splines in Bernstein-Bezier form, parts of them, and a bound on how far they bend") {
    test::Random random(2);
    Net12 net;
    for (Vec3d& p : net) p = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const BezierTriangle<4> whole = box_spline_triangle(net);
    const double bend = linear_deviation(net);
    for (int round = 0; round < 100; ++round) {
        const Bary b = random_bary(random);
        CHECK(glm::length(value(whole, b) - box_spline_position(net, b)) < 1e-14);
        const Vec3d linear = b[0] * whole.point[whole.corner(0)] + b[1] * whole.point[whole.corner(1)] +
                             b[2] * whole.point[whole.corner(2)];
        CHECK(glm::length(value(whole, b) - linear) <= bend);
        const std::array<Bary, 3> at{random_bary(random), random_bary(random), random_bary(random)};
        const BezierTriangle<4> part = whole.over(at);
        Bary p{};
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t c = 0; c < 3; ++c) p[c] += b[k] * at[k][c];
        CHECK(glm::length(value(part, b) - box_spline_position(net, p)) < 1e-14);
    }
}

TEST_CASE("second differences bound what a bicubic patch is off its linear interpolant, exactly for quadratics") {
    test::Random random(4);
    const auto largest = [](const Net16& net, const std::array<Vec2d, 3>& at) {
        const auto surface = [&](const Vec2d& p) { return combine(net, cubic_basis(p.x), cubic_basis(p.y)); };
        double worst = 0;
        for (int i = 0; i <= 16; ++i)
            for (int j = 0; i + j <= 16; ++j) {
                const double a = i / 16.0, b = j / 16.0, c = 1 - a - b;
                worst = std::max(worst, glm::length(surface(a * at[0] + b * at[1] + c * at[2]) -
                                                    (a * surface(at[0]) + b * surface(at[1]) + c * surface(at[2]))));
            }
        return worst;
    };
    const std::array<Vec2d, 3> half = {{{1, 0}, {0, 1}, {0, 0}}}, quarter = {{{0, 0}, {1, 0}, {0.5, 0.5}}};
    Net16 net;
    for (int round = 0; round < 50; ++round) {
        for (auto& row : net.c)
            for (double& x : row) x = random.uniform(-1, 1);
        const Vec2d a(random.uniform(0, 1), random.uniform(0, 1)), b(random.uniform(0, 1), random.uniform(0, 1));
        for (const auto& at : {half, quarter, std::array<Vec2d, 3>{a, b, Vec2d(random.uniform(0, 1), 0.5)}})
            CHECK(bicubic_deviation(net, at) >= largest(net, at) - 1e-12);
    }
    for (int y = -1; y <= 2; ++y)
        for (int x = -1; x <= 2; ++x) net.set(x, y, {5.0 * x - y, 3.0 * y, double(x * x)});
    for (const auto& at : {half, quarter}) CHECK(bicubic_deviation(net, at) == doctest::Approx(largest(net, at)));
}

TEST_SUITE_END();
