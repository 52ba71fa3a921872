#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/families/error_estimator.hpp"
#include "../distance/limit_samples.hpp"

#include <span>
#include <vector>

namespace tetrakis {

namespace detail {

/// What limit points one and two levels further down see is at least this share of the error: the surface may be
/// farther between them, by a sixteenth where it is smooth; of interpolating schemes by a tenth, where faces are five
/// times narrower than their neighbours (Kobbelt's on Suzanne).
inline double seen_share(const SchemeInfo& scheme) { return scheme.interpolating && !scheme.is_linear() ? 0.9 : 0.94; }

/// The errors of faces' fans (eval/README.md) over a surface that is known by its limit points, as LimitEstimator finds
/// those of triangles: limit points over all of the face to the nearest triangle of its fan, and back; hard edges to
/// themselves. 0 for faces without a fan.
/// @param points            of the bisection family
/// @param corner_positions  of the control vertices in the output
std::vector<double> fan_limit_errors(const Hierarchy& points, const FanChoice& fans,
                                     std::span<const Vec3d> corner_positions, const RunContext& context);

}  // namespace detail

/// The error of triangles of a hierarchy over a surface that is known by its limit points alone: the distances of the
/// points that the triangle's edges and inside have two levels further down, to the triangle as PlaneMeasure takes it;
/// back from the triangle to them where they have drifted away sideways; and along boundaries and hard creases to the
/// triangle's own edge. No bound: the surface can be farther between the points.
template <class Family>
class LimitEstimator final : public ErrorEstimator {
  public:
    /// @param points     gives the limit points; lives longer
    /// @param tolerance  triangles that are farther off are not looked at from the other side. 0: all are
    LimitEstimator(const Hierarchy& points, double tolerance) : points_(points), tolerance_(tolerance) {}

    using ErrorEstimator::estimate;
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override;

  private:
    double of_samples(const CellTriangle& triangle, const detail::LimitSamples& samples) const;

    const Hierarchy& points_;
    double tolerance_;
};

}  // namespace tetrakis
