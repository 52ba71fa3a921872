#pragma once

#include <glm/vec3.hpp>

#include <span>
#include <vector>

namespace tetrakis {

using CurvePoints = std::vector<glm::dvec3>;

enum class CurveTopology { open, closed };

/// Treatment of the ends of a B-spline's open control polygon.
enum class CurveEnds {
    plain,    ///< none: doubling and averaging drop points, and the curve begins inside the polygon
    clamped,  ///< the end points are repeated, so the curve begins at the first control point (degree k: k - 1 copies)
    /// The end points stay, as at boundaries of surfaces, and all other points of degree 3 have the plain rules
    /// (1, 6, 1) / 8 and (1, 1) / 2. Degrees 1 and 3.
    fixed,
};

/// The new point of the four-point rule in the first and last span of an open polygon, by extrapolation.
enum class FourPointEnds {
    plain,      ///< none: the first and last span are dropped, as they have no rule
    linear,     ///< (7, 10, -1) / 16
    quadratic,  ///< (3, 6, -1) / 8
    cubic,      ///< (5, 15, -5, 1) / 16
};

/// Control points of the halves of a Bezier curve of any degree, by de Casteljau's algorithm at 1/2. The last point of
/// `first` is the first point of `second`.
struct BezierHalves {
    CurvePoints first, second;
};
BezierHalves split_bezier(std::span<const glm::dvec3> control);

/// One step of a uniform B-spline of degree k >= 1: every point is doubled, then neighbours are averaged k times (Lane,
/// Riesenfeld 1980). Open and plain: m points give 2m - k. Closed: they give 2m, of which numbers 2i and 2i + 1 are the
/// children of point i.
///
/// Clamped ends are refined as plain ones here: clamped_bspline() repeats the end points once, before the first step.
/// @throws std::invalid_argument  degree < 1, too few points for one span (degree + 1; closed: 1), or fixed ends with a
///                                degree that has no rule for them
CurvePoints bspline_step(std::span<const glm::dvec3> control, int degree, CurveTopology topology,
                         CurveEnds ends = CurveEnds::plain);
/// The control points with degree - 1 more copies of each end point, for clamped ends.
CurvePoints clamped_bspline(std::span<const glm::dvec3> control, int degree);
/// The limit curve at its knots. Open and plain: m points have m - k + 1 knots, the curve's ends included; closed: m.
/// Number i is a combination of points i .. i + k - 1 (for k = 3 it is the limit of point i + 1).
CurvePoints bspline_limits(std::span<const glm::dvec3> control, int degree, CurveTopology topology);

/// One step of the four-point rule (Dyn, Gregory, Levin 1987; w = 1/16): old points stay, between two comes
/// (-1, 9, 9, -1) / 16. Open polygons: see FourPointEnds.
/// @throws std::invalid_argument  fewer points than the rule at the ends needs: plain 4; linear 2; quadratic 3;
///                                cubic 4; closed 3
CurvePoints four_point_step(std::span<const glm::dvec3> points, CurveTopology topology,
                            FourPointEnds ends = FourPointEnds::cubic);

/// A polygon that approximates a curve, with an error bound.
struct CurvePolyline {
    CurvePoints points;  ///< on the curve; of a closed curve the first point is not repeated at the end
    /// Bound of the distance of the curve's points from the polygon, and of the polygon's from the curve. At most the
    /// tolerance, unless that needs too many points (k_most_curve_points).
    double error = 0;
};

/// A Bezier curve as a polygon: parts that are not within the tolerance of their chord are halved. The error bound is
/// the distance of the control points from the chord, as the curve lies in their hull.
/// @throws std::invalid_argument  no control point, coordinates that are not finite or beyond 1e60, or a tolerance that
///                                is not positive; the next two functions as well
CurvePolyline adaptive_bezier(std::span<const glm::dvec3> control, double tolerance);
/// A B-spline as a polygon. It is refined until chords between its knots are within a quarter of the tolerance: an
/// eighth of the largest second difference of the control points bounds their distance. Then points are left out, by
/// halving spans, as far as the rest of the tolerance allows.
CurvePolyline adaptive_bspline(std::span<const glm::dvec3> control, int degree, CurveTopology topology, CurveEnds ends,
                               double tolerance);
/// The four-point curve in the same way. With M the largest second difference, the curve is at most M / 2 from its
/// polygon: a new point is at most M / 8 from its chord, and the next level's second differences are at most 3/4 M.
/// Cubic ends: M / 4 and 7/8 M, so 2 M. With plain ends every level drops spans there, and of n points the curve
/// between the third and the last but two is left.
/// @throws std::invalid_argument  as four_point_step(); plain ends with fewer than 6 points
CurvePolyline adaptive_four_point(std::span<const glm::dvec3> points, CurveTopology topology, FourPointEnds ends,
                                  double tolerance);
inline constexpr int k_most_curve_points = 1 << 20;

}  // namespace tetrakis
