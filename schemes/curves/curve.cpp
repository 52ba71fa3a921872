#include "curve.hpp"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace tetrakis {

namespace {

void need_points(std::span<const glm::dvec3> points, int count, const char* what) {
    if (static_cast<int>(points.size()) < count)
        throw std::invalid_argument(std::string(what) + " needs at least " + std::to_string(count) + " points");
}

void check_degree(int degree) {
    if (degree < 1) throw std::invalid_argument("the degree of a B-spline must be at least 1");
}

void check_tolerance(double tolerance) {
    if (!(tolerance > 0)) throw std::invalid_argument("the tolerance must be positive");
}

/// Much larger coordinates have infinite squares, and the bounds computed from these are not numbers.
void check_coordinates(std::span<const glm::dvec3> control) {
    constexpr double k_largest = 1e60;
    for (const glm::dvec3& p : control)
        for (int i = 0; i < 3; ++i)
            if (!(std::abs(p[i]) <= k_largest))
                throw std::invalid_argument("a control point has a coordinate that is not finite, or beyond 1e60");
}

double distance_to_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 d = b - a;
    const double square = glm::dot(d, d);
    const double t = square > 0 ? std::clamp(glm::dot(p - a, d) / square, 0.0, 1.0) : 0.0;
    return glm::distance(p, a + t * d);
}

double largest_second_difference(const CurvePoints& p, bool closed) {
    const std::size_t n = p.size();
    double most = 0;
    for (std::size_t i = closed ? 0 : 1; i < (closed ? n : n - std::min<std::size_t>(n, 1)); ++i)
        most = std::max(most, glm::length(p[(i + n - 1) % n] - 2.0 * p[i] + p[(i + 1) % n]));
    return most;
}

/// Appends points from `first` to before `last` to `out`, by halving this span until all points of a part are within
/// `slack` of its chord. Returns the largest distance of a point that is left out.
double thin(const CurvePoints& p, std::size_t first, std::size_t last, double slack, CurvePoints& out) {
    const glm::dvec3& a = p[first % p.size()];
    const glm::dvec3& b = p[last % p.size()];
    double most = 0;
    for (std::size_t i = first + 1; i < last && most <= slack; ++i)
        most = std::max(most, distance_to_segment(p[i], a, b));
    if (most <= slack) {
        out.push_back(a);
        return most;
    }
    const std::size_t middle = first + (last - first) / 2;
    const double before = thin(p, first, middle, slack, out);
    return std::max(before, thin(p, middle, last, slack, out));
}

CurvePolyline thinned(const CurvePoints& p, bool closed, double bound, double tolerance, std::size_t start_spans) {
    CurvePolyline line;
    const double slack = std::max(0.0, tolerance - bound);
    double left = 0;
    // A chord covers at most a span of the control polygon: one around a whole closed curve would have equal ends.
    const std::size_t total = closed ? p.size() : p.size() - 1, step = std::max<std::size_t>(1, total / start_spans);
    for (std::size_t i = 0; i < total; i += step)
        left = std::max(left, thin(p, i, std::min(i + step, total), slack, line.points));
    if (!closed) line.points.push_back(p.back());
    line.error = bound + left;
    return line;
}

/// Values of the uniform B-spline of degree k at its inner knots 1 .. k.
std::vector<double> knot_values(int k) {
    std::vector<double> n{1};
    // N_d(i) = (i N_(d-1)(i) + (d + 1 - i) N_(d-1)(i - 1)) / d, from the values of degree d - 1.
    for (int d = 2; d <= k; ++d) {
        std::vector<double> next(d);
        for (int i = 1; i <= d; ++i)
            next[i - 1] = ((i < d ? i * n[i - 1] : 0.0) + (i > 1 ? (d + 1 - i) * n[i - 2] : 0.0)) / d;
        n = std::move(next);
    }
    return n;
}

/// The open control polygon that gives the same curve with CurveEnds::plain.
CurvePoints with_plain_ends(std::span<const glm::dvec3> control, int degree, CurveEnds ends) {
    if (ends == CurveEnds::clamped) return clamped_bspline(control, degree);
    CurvePoints points(control.begin(), control.end());
    if (ends == CurveEnds::plain || degree == 1) return points;
    if (degree != 3) throw std::invalid_argument("fixed ends have rules for degrees 1 and 3 only; clamp the curve");
    need_points(control, 2, "a curve with fixed ends");
    // The new point before an end mirrors the end's neighbour: refinement keeps this symmetry, so the end stays.
    points.insert(points.begin(), 2.0 * control[0] - control[1]);
    points.push_back(2.0 * control.back() - control[control.size() - 2]);
    return points;
}

}  // namespace

BezierHalves split_bezier(std::span<const glm::dvec3> control) {
    need_points(control, 1, "a Bezier curve");
    CurvePoints row(control.begin(), control.end());
    BezierHalves halves;
    halves.second.resize(row.size());
    for (std::size_t left = row.size(); left > 0; --left) {
        halves.first.push_back(row[0]);
        halves.second[left - 1] = row[left - 1];
        for (std::size_t i = 0; i + 1 < left; ++i) row[i] = 0.5 * (row[i] + row[i + 1]);
    }
    return halves;
}

CurvePoints clamped_bspline(std::span<const glm::dvec3> control, int degree) {
    check_degree(degree);
    need_points(control, 1, "a B-spline");
    CurvePoints points(degree - 1, control.front());
    points.insert(points.end(), control.begin(), control.end());
    points.insert(points.end(), degree - 1, control.back());
    return points;
}

CurvePoints bspline_step(std::span<const glm::dvec3> control, int degree, CurveTopology topology, CurveEnds ends) {
    check_degree(degree);
    const bool closed = topology == CurveTopology::closed;
    if (closed) {
        need_points(control, 1, "a closed B-spline");
    } else if (ends == CurveEnds::fixed) {
        CurvePoints fine = bspline_step(with_plain_ends(control, degree, ends), degree, topology);
        // Removes the points made beyond the ends, and the rounding errors of the ends.
        if (degree == 3) fine = {fine.begin() + 1, fine.end() - 1};
        fine.front() = control.front();
        fine.back() = control.back();
        return fine;
    } else {
        need_points(control, degree + 1, "a B-spline of this degree");
    }
    CurvePoints fine;
    fine.reserve(2 * control.size());
    for (const glm::dvec3& p : control) fine.insert(fine.end(), 2, p);
    for (int i = 0; i < degree; ++i) {
        const glm::dvec3 first = fine.front();
        for (std::size_t j = 0; j + 1 < fine.size(); ++j) fine[j] = 0.5 * (fine[j] + fine[j + 1]);
        if (closed)
            fine.back() = 0.5 * (fine.back() + first);
        else
            fine.pop_back();
    }
    return fine;
}

CurvePoints bspline_limits(std::span<const glm::dvec3> control, int degree, CurveTopology topology) {
    check_degree(degree);
    const bool closed = topology == CurveTopology::closed;
    need_points(control, closed ? 1 : degree + 1, "a B-spline of this degree");
    const std::vector<double> weights = knot_values(degree);
    const std::size_t n = control.size();
    CurvePoints limits(closed ? n : n - degree + 1, glm::dvec3(0));
    for (std::size_t i = 0; i < limits.size(); ++i)
        for (int j = 0; j < degree; ++j) limits[i] += weights[j] * control[(i + j) % n];
    return limits;
}

CurvePoints four_point_step(std::span<const glm::dvec3> p, CurveTopology topology, FourPointEnds ends) {
    const bool closed = topology == CurveTopology::closed;
    const bool plain = !closed && ends == FourPointEnds::plain;
    const int least = closed                             ? 3
                      : plain                            ? 4
                      : ends == FourPointEnds::linear    ? 2
                      : ends == FourPointEnds::quadratic ? 3
                                                         : 4;
    need_points(p, least, "the four-point rule");
    const std::size_t n = p.size(), spans = closed ? n : n - 1;
    const auto end_point = [&](std::size_t i, std::ptrdiff_t s) {
        // The new point of the span from point i in direction s, at an end of the polygon.
        const auto at = [&](std::ptrdiff_t k) { return p[i + s * k]; };
        if (ends == FourPointEnds::cubic) return (5.0 * at(0) + 15.0 * at(1) - 5.0 * at(2) + at(3)) / 16.0;
        if (ends == FourPointEnds::quadratic) return (3.0 * at(0) + 6.0 * at(1) - at(2)) / 8.0;
        if (n == 2) return 0.5 * (at(0) + at(1));  // the only span has no third point
        return (7.0 * at(0) + 10.0 * at(1) - at(2)) / 16.0;
    };
    CurvePoints fine;
    fine.reserve(2 * n);
    for (std::size_t i = 0; i < spans; ++i) {
        const bool first = !closed && i == 0, last = !closed && i + 1 == spans;
        if (plain && first) continue;
        fine.push_back(p[i]);
        if (plain && last) return fine;
        if (first)
            fine.push_back(end_point(0, 1));
        else if (last)
            fine.push_back(end_point(n - 1, -1));
        else
            fine.push_back((9.0 * (p[i] + p[(i + 1) % n]) - (p[(i + n - 1) % n] + p[(i + 2) % n])) / 16.0);
    }
    if (!closed) fine.push_back(p[n - 1]);
    return fine;
}

CurvePolyline adaptive_bezier(std::span<const glm::dvec3> control, double tolerance) {
    need_points(control, 1, "a Bezier curve");
    check_tolerance(tolerance);
    check_coordinates(control);
    CurvePolyline line;
    struct Part {
        CurvePoints points;
        int level;
    };
    // Depth first, with the first half on top; parts at the deepest level are not halved.
    constexpr int k_most_level = 20;
    std::vector<Part> stack{{CurvePoints(control.begin(), control.end()), 0}};
    while (!stack.empty()) {
        const Part part = std::move(stack.back());
        stack.pop_back();
        double bound = 0;
        for (const glm::dvec3& p : part.points)
            bound = std::max(bound, distance_to_segment(p, part.points.front(), part.points.back()));
        if (bound <= tolerance || part.level == k_most_level) {
            line.points.push_back(part.points.front());
            line.error = std::max(line.error, bound);
            continue;
        }
        BezierHalves halves = split_bezier(part.points);
        stack.push_back({std::move(halves.second), part.level + 1});
        stack.push_back({std::move(halves.first), part.level + 1});
    }
    line.points.push_back(control.back());
    return line;
}

CurvePolyline adaptive_bspline(std::span<const glm::dvec3> control, int degree, CurveTopology topology, CurveEnds ends,
                               double tolerance) {
    check_degree(degree);
    check_tolerance(tolerance);
    check_coordinates(control);
    const bool closed = topology == CurveTopology::closed;
    CurvePoints points = closed ? CurvePoints(control.begin(), control.end()) : with_plain_ends(control, degree, ends);
    need_points(points, closed ? 1 : degree + 1, "a B-spline of this degree");
    const std::size_t spans = closed ? points.size() : points.size() - degree;
    // The second derivative between knots is a mean of second differences of the control points. For degree 1 the
    // polygon through the knots is the curve.
    const auto bound = [&] { return degree == 1 ? 0.0 : largest_second_difference(points, closed) / 8; };
    while (bound() > tolerance / 4 && static_cast<int>(points.size()) < k_most_curve_points)
        points = bspline_step(points, degree, topology);
    return thinned(bspline_limits(points, degree, topology), closed, bound(), tolerance, spans);
}

CurvePolyline adaptive_four_point(std::span<const glm::dvec3> control, CurveTopology topology, FourPointEnds ends,
                                  double tolerance) {
    check_tolerance(tolerance);
    check_coordinates(control);
    const bool closed = topology == CurveTopology::closed, plain = !closed && ends == FourPointEnds::plain;
    if (plain) need_points(control, 6, "a span of the four-point curve without rules for its ends");
    CurvePoints points = four_point_step(control, topology, ends);
    const std::size_t spans = closed  ? control.size()
                              : plain ? control.size() - 5
                                      : std::max<std::size_t>(1, control.size() - 1);
    // See the header for the constants.
    const double factor = !closed && ends == FourPointEnds::cubic ? 2.0 : 0.5;
    const auto bound = [&] { return factor * largest_second_difference(points, closed); };
    while (bound() > tolerance / 4 && static_cast<int>(points.size()) < k_most_curve_points)
        points = four_point_step(points, topology, ends);
    const double error = bound();
    // Further levels would drop 1 + 1/2 + 1/4 + ... = 2 more spans of this level at each end.
    if (plain) points = CurvePoints(points.begin() + 2, points.end() - 2);
    return thinned(points, closed, error, tolerance, spans);
}

}  // namespace tetrakis
