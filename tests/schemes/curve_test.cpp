#include "../../schemes/curves/curve.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>

using namespace tetrakis;

namespace {

CurvePoints random_points(int count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> u(-1, 1);
    CurvePoints points(count);
    for (auto& p : points) p = {u(random), u(random), u(random)};
    return points;
}

glm::dvec3 bezier_at(const CurvePoints& p, double t) {
    glm::dvec3 sum(0);
    const int d = static_cast<int>(p.size()) - 1;
    double binomial = 1;
    for (int i = 0; i <= d; ++i) {
        sum += binomial * std::pow(t, i) * std::pow(1 - t, d - i) * p[i];
        binomial = binomial * (d - i) / (i + 1);
    }
    return sum;
}

/// Cox-de Boor: the uniform B-spline of degree k on [0, k + 1].
double basis(int k, double x) {
    if (k == 0) return x >= 0 && x < 1 ? 1 : 0;
    return x / k * basis(k - 1, x) + (k + 1 - x) / k * basis(k - 1, x - 1);
}

/// The curve at x = k .. point count (open), any x (closed).
glm::dvec3 bspline_at(const CurvePoints& p, int k, double x, bool closed) {
    glm::dvec3 sum(0);
    const int n = static_cast<int>(p.size());
    for (int i = static_cast<int>(std::floor(x)) - k; i <= std::floor(x); ++i)
        if (closed || (i >= 0 && i < n)) sum += basis(k, x - i) * p[((i % n) + n) % n];
    return sum;
}

double distance(const glm::dvec3& p, const CurvePoints& line, bool closed) {
    double best = 1e300;
    for (std::size_t i = 0; i + (closed ? 0 : 1) < line.size(); ++i) {
        const glm::dvec3 a = line[i], d = line[(i + 1) % line.size()] - a;
        const double square = glm::dot(d, d), t = square > 0 ? std::clamp(glm::dot(p - a, d) / square, 0.0, 1.0) : 0;
        best = std::min(best, glm::distance(p, a + t * d));
    }
    return best;
}

double largest_difference(const CurvePoints& a, const CurvePoints& b) {
    REQUIRE(a.size() == b.size());
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, glm::distance(a[i], b[i]));
    return most;
}

/// Power of the rules: polynomial of a degree, sampled at x.
CurvePoints sampled(int degree, const std::function<double(int)>& x, int count) {
    CurvePoints p;
    for (int i = 0; i < count; ++i) p.emplace_back(x(i), std::pow(x(i), degree), 0);
    return p;
}

}  // namespace

TEST_SUITE_BEGIN("schemes");

TEST_CASE("de Casteljau's halves are the Bezier curve of each half") {
    for (int degree = 0; degree <= 6; ++degree) {
        const CurvePoints p = random_points(degree + 1, degree + 1);
        const BezierHalves halves = split_bezier(p);
        CHECK(halves.first.back() == halves.second.front());
        for (const double t : {0.0, 0.3, 0.5, 1.0}) {
            CHECK(glm::distance(bezier_at(halves.first, t), bezier_at(p, t / 2)) < 1e-14);
            CHECK(glm::distance(bezier_at(halves.second, t), bezier_at(p, 0.5 + t / 2)) < 1e-14);
        }
    }
}

TEST_CASE("doubling and averaging keeps the B-spline, whatever its degree, open and closed") {
    for (int k = 1; k <= 8; ++k) {
        CAPTURE(k);
        const CurvePoints p = random_points(k + 5, k);
        for (const auto topology : {CurveTopology::open, CurveTopology::closed}) {
            const bool closed = topology == CurveTopology::closed;
            const CurvePoints fine = bspline_step(p, k, topology);
            CHECK(fine.size() == (closed ? 2 * p.size() : 2 * p.size() - k));
            const double end = closed ? 9 : p.size() - 1e-9;
            for (double x = k; x < end; x += 0.37) {
                // Fine point i starts where the coarse parameter is (i + k) / 2.
                const double y = 2 * x - k;
                CHECK(glm::distance(bspline_at(p, k, x, closed), bspline_at(fine, k, y, closed)) < 1e-13);
            }
            const CurvePoints limits = bspline_limits(p, k, topology);
            for (std::size_t i = 0; i < limits.size(); ++i)
                CHECK(glm::distance(limits[i],
                                    bspline_at(p, k, double(i) + k + (i + 1 == limits.size() && !closed ? -1e-12 : 0),
                                               closed)) < 1e-10);
        }
    }
}

TEST_CASE("ends: clamped curves start at the first point, fixed ones keep it, plain ones recede") {
    const CurvePoints p = random_points(7, 5);
    for (int k = 1; k <= 5; ++k) {
        const CurvePoints limits = bspline_limits(clamped_bspline(p, k), k, CurveTopology::open);
        CHECK(glm::distance(limits.front(), p.front()) < 1e-15);
        CHECK(glm::distance(limits.back(), p.back()) < 1e-15);
    }
    CurvePoints fixed = p, plain = p;
    for (int i = 0; i < 6; ++i) {
        fixed = bspline_step(fixed, 3, CurveTopology::open, CurveEnds::fixed);
        plain = bspline_step(plain, 3, CurveTopology::open);
    }
    CHECK(fixed.front() == p.front());
    CHECK(fixed.back() == p.back());
    // The plain curve starts at the limit of the second point.
    CHECK(glm::distance(plain.front(), (p[0] + 4.0 * p[1] + p[2]) / 6.0) < 0.05);
    CHECK_THROWS_AS(bspline_step(p, 2, CurveTopology::open, CurveEnds::fixed), std::invalid_argument);
    CHECK_THROWS_AS(bspline_step(p, 0, CurveTopology::open), std::invalid_argument);
    CHECK_THROWS_AS(bspline_step(random_points(3, 1), 3, CurveTopology::open), std::invalid_argument);
}

TEST_CASE("the four-point rule keeps its points and reproduces cubics, at the ends what the end rule says") {
    const std::pair<FourPointEnds, int> rules[] = {
        {FourPointEnds::linear, 1}, {FourPointEnds::quadratic, 2}, {FourPointEnds::cubic, 3}};
    for (const auto& [ends, degree] : rules)
        for (int d = 1; d <= degree; ++d) {
            const CurvePoints p = sampled(
                d, [](int i) { return i / 4.0 - 1; }, 9);
            const CurvePoints fine = four_point_step(p, CurveTopology::open, ends);
            CHECK(largest_difference(fine, sampled(
                                               d, [](int i) { return i / 8.0 - 1; }, 17)) < 1e-14);
        }
    const CurvePoints p = random_points(8, 2);
    for (const auto topology : {CurveTopology::open, CurveTopology::closed}) {
        const CurvePoints fine = four_point_step(p, topology);
        for (std::size_t i = 0; i < p.size(); ++i) CHECK(fine[2 * i] == p[i]);
        CHECK(fine[5] == (9.0 * (p[2] + p[3]) - (p[1] + p[4])) / 16.0);
    }
    // Without a rule at the ends the first and last span are dropped.
    const CurvePoints plain = four_point_step(p, CurveTopology::open, FourPointEnds::plain);
    CHECK(plain.size() == 2 * p.size() - 5);
    CHECK(plain.front() == p[1]);
    CHECK(plain.back() == p[6]);
    CHECK_THROWS_AS(four_point_step(random_points(3, 1), CurveTopology::open, FourPointEnds::cubic),
                    std::invalid_argument);
}

TEST_CASE("adaptive polygons are within their tolerance of the curve, and no finer than that takes") {
    for (unsigned seed = 1; seed <= 4; ++seed) {
        CAPTURE(seed);
        std::size_t before = 0;
        for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) {
            CAPTURE(tolerance);
            const CurvePoints bezier = random_points(5, seed);
            const CurvePolyline line = adaptive_bezier(bezier, tolerance);
            CHECK(line.error <= tolerance);
            for (double t = 0; t <= 1; t += 0.01)
                CHECK(distance(bezier_at(bezier, t), line.points, false) <= line.error + 1e-14);
            CHECK(line.points.front() == bezier.front());
            CHECK(line.points.back() == bezier.back());
            CHECK(line.points.size() > before);
            // A tenth of the error costs the square root of ten times the points, and halves round up to two.
            if (before > 8) CHECK(line.points.size() < 7 * before);
            before = line.points.size();
            const CurvePoints p = random_points(8, seed + 10);
            for (int k = 1; k <= 4; ++k)
                for (const auto topology : {CurveTopology::open, CurveTopology::closed}) {
                    const bool closed = topology == CurveTopology::closed;
                    const CurvePolyline spline = adaptive_bspline(p, k, topology, CurveEnds::plain, tolerance);
                    CHECK(spline.error <= tolerance);
                    double most = 0;
                    for (double x = k; x < (closed ? k + 8.0 : 8.0); x += 0.02)
                        most = std::max(most, distance(bspline_at(p, k, x, closed), spline.points, closed));
                    CHECK(most <= spline.error + 1e-13);
                }
            for (const auto ends : {FourPointEnds::linear, FourPointEnds::quadratic, FourPointEnds::cubic}) {
                const CurvePolyline line4 = adaptive_four_point(p, CurveTopology::open, ends, tolerance);
                CHECK(line4.error <= tolerance);
                CurvePoints fine = p;
                for (int i = 0; i < 7; ++i) fine = four_point_step(fine, CurveTopology::open, ends);
                double most = 0;
                for (const auto& q : fine) most = std::max(most, distance(q, line4.points, false));
                CHECK(most <= line4.error + 1e-13);
            }
        }
    }
    // Without rules for the ends: from the third point to the last but two, whatever the level it stops at.
    const CurvePoints nine = random_points(9, 5);
    for (const double tolerance : {1.0, 1e-2, 1e-4}) {
        const CurvePolyline line = adaptive_four_point(nine, CurveTopology::open, FourPointEnds::plain, tolerance);
        CHECK(line.points.front() == nine[2]);
        CHECK(line.points.back() == nine[6]);
        CurvePoints fine = nine;
        for (int i = 0; i < 8; ++i) fine = four_point_step(fine, CurveTopology::open, FourPointEnds::plain);
        double most = 0;
        for (std::size_t i = 2; i + 2 < fine.size(); ++i) most = std::max(most, distance(fine[i], line.points, false));
        CHECK(most <= line.error + 1e-13);
    }
    CHECK_THROWS_WITH(adaptive_four_point(random_points(5, 1), CurveTopology::open, FourPointEnds::plain, 1e-11),
                      doctest::Contains("6 points"));
    CurvePoints bad = random_points(6, 1);
    bad[3].y = std::numeric_limits<double>::quiet_NaN();
    CHECK_THROWS_AS(adaptive_bezier(bad, 1e-3), std::invalid_argument);
    CHECK_THROWS_AS(adaptive_bspline(bad, 3, CurveTopology::closed, CurveEnds::plain, 1e-3), std::invalid_argument);
    CHECK_THROWS_AS(adaptive_four_point(bad, CurveTopology::closed, FourPointEnds::plain, 1e-3), std::invalid_argument);
    bad[3].y = 1e160;
    CHECK_THROWS_AS(adaptive_bezier(bad, 1e-3), std::invalid_argument);
    // A straight line needs its ends alone.
    CHECK(adaptive_bezier(CurvePoints{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, 1e-6).points.size() == 2);
    CHECK_THROWS_AS(adaptive_bezier(random_points(3, 1), 0), std::invalid_argument);
    const CurvePoints p = random_points(5, 1);
    const CurvePolyline fixed = adaptive_bspline(p, 3, CurveTopology::open, CurveEnds::fixed, 1e-2);
    CHECK(glm::distance(fixed.points.front(), p.front()) < 1e-14);
    CHECK(glm::distance(fixed.points.back(), p.back()) < 1e-14);
}

TEST_SUITE_END();
