#pragma once

#include <glm/vec3.hpp>

#include <span>
#include <vector>

namespace tetrakis {

using CurvePoints = std::vector<glm::dvec3>;

enum class CurveTopology { open, closed };

/// What a B-spline does at the ends of an open control polygon.
enum class CurveEnds {
    plain,    ///< nothing: doubling and averaging drop points, and the curve begins inside the polygon
    clamped,  ///< the end points are repeated, so the curve begins at the first control point (degree k: k - 1 copies)
    /// The ends by a rule of their own, as boundaries of surfaces do: the end point stays, and for degree 3 all other
    /// rules are the plain ones (1, 6, 1) / 8 and (1, 1) / 2. Degrees 1 and 3.
    fixed,
};

/// The new point of the four-point rule in the first and last span of an open polygon, by extrapolation.
enum class FourPointEnds {
    plain,      ///< none: the first and last span are dropped, as they have no rule
    linear,     ///< (7, 10, -1) / 16
    quadratic,  ///< (3, 6, -1) / 8
    cubic,      ///< (5, 15, -5, 1) / 16
};

/// A Bezier curve cut at 1/2 by de Casteljau's algorithm: the control points of its halves, of which the last of the
/// first is the first of the second. Any degree.
struct BezierHalves {
    CurvePoints first, second;
};
BezierHalves split_bezier(std::span<const glm::dvec3> control);

/// One step of a uniform B-spline of degree k >= 1: every point doubled, then k averages of neighbours (Lane,
/// Riesenfeld 1980). Open and plain: m points give 2m - k; closed: 2m, of which number 2i and 2i + 1 descend from point
/// i.
///
/// Clamped control points are repeated once, by clamped_bspline(), and then refined as plain ones.
/// @throws std::invalid_argument  degree < 1, too few points for one span (degree + 1; closed: 1), or fixed ends with a
///                                degree that has no rule for them
CurvePoints bspline_step(std::span<const glm::dvec3> control, int degree, CurveTopology topology,
                         CurveEnds ends = CurveEnds::plain);
/// The control points with those at the ends repeated for a clamped start: degree - 1 more of each end.
CurvePoints clamped_bspline(std::span<const glm::dvec3> control, int degree);
/// The limit curve at its knots. Open and plain: m points have m - k + 1 of them, the curve's ends included; closed: m,
/// the one of the span that starts at point i being number i (for k = 3 the limit of point i + 1).
CurvePoints bspline_limits(std::span<const glm::dvec3> control, int degree, CurveTopology topology);

/// One step of the four-point rule (Dyn, Gregory, Levin 1987; w = 1/16): old points stay, between two comes
/// (-1, 9, 9, -1) / 16. Open polygons: see FourPointEnds.
/// @throws std::invalid_argument  fewer points than the rule at the ends needs: plain 4; linear 2; quadratic 3;
///                                cubic 4; closed 3
CurvePoints four_point_step(std::span<const glm::dvec3> points, CurveTopology topology,
                            FourPointEnds ends = FourPointEnds::cubic);

/// A curve to draw, and how far it may be from the polygon that is returned.
struct CurvePolyline {
    CurvePoints points;  ///< on the curve; of a closed curve the first point is not repeated at the end
    /// No point of the curve is farther from the polygon than this, nor the other way round. At most the tolerance,
    /// unless that is out of reach (k_most_curve_points).
    double error = 0;
};

/// A Bezier curve as a polygon, halved where it is not yet within the tolerance of its chord. The bound is the distance
/// of the control points from the chord: the curve lies in their hull.
/// @throws std::invalid_argument  no control point, coordinates that are not finite or beyond 1e60, or a tolerance that
///                                is not positive; so do the next two
CurvePolyline adaptive_bezier(std::span<const glm::dvec3> control, double tolerance);
/// A B-spline: refined until chords between its knots are within a part of the tolerance (an eighth of the largest
/// second difference of the control points bounds their distance), then as few of these points as the rest of it
/// allows, by halves.
CurvePolyline adaptive_bspline(std::span<const glm::dvec3> control, int degree, CurveTopology topology, CurveEnds ends,
                               double tolerance);
/// The four-point curve in the same way. The largest second difference M bounds the distance from the polygon by M / 2:
/// a new point is M / 8 from its chord at most, and the next level's second differences are 3/4 M at most. Cubic ends:
/// M / 4 and 7/8 M, so 2 M. Without rules for the ends every level drops spans there: what is left of n points is the
/// curve between the third and the last but two.
/// @throws std::invalid_argument  as four_point_step(); plain ends with fewer than 6 points
CurvePolyline adaptive_four_point(std::span<const glm::dvec3> points, CurveTopology topology, FourPointEnds ends,
                                  double tolerance);
inline constexpr int k_most_curve_points = 1 << 20;

}  // namespace tetrakis
