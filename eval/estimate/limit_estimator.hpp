#pragma once

#include "../../hier/mesh/fan_choice.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/families/error_estimator.hpp"

#include <span>

namespace tetrakis::detail {

/// A leaf's error needs points of this many simple steps of sqrt(3) below its level, which the lattice must have.
inline constexpr int k_sqrt3_error_steps = 6;

/// Least share of the true error that limit points of the next two levels show. Between them a smooth surface may be
/// farther off by a sixteenth; surfaces of interpolating schemes by a tenth, where faces are five times narrower than
/// their neighbours (measured: Kobbelt's scheme on Suzanne).
inline double seen_share(const SchemeInfo& scheme) { return scheme.interpolating && !scheme.is_linear() ? 0.9 : 0.94; }

/// Errors of faces' fans (eval/README.md) by limit points, as LimitEstimator finds errors of triangles. Limit points of
/// the whole face are measured to the nearest triangle of its fan, and back; points on hard edges to the fan's own
/// edge.
/// @param points   gives the limit points; of the bisection family
/// @param corners  output positions of the control vertices
void fan_limit_errors(const Hierarchy& points, const FanChoice& fans, std::span<const FaceId> faces,
                      std::span<const Vec3d> corners, std::span<double> errors);

/// Errors of a hierarchy's triangles by the limit points that two more levels put on a triangle's edges and inside it.
/// Distances go from these points to the triangle (PlaneMeasure); on boundaries and hard creases, to its own edge.
/// Except for sqrt(3), they also go back from points of the triangle that are far from their own sample. The result is
/// no bound: between the points the surface may be farther off.
class LimitEstimator final : public ErrorEstimator {
  public:
    /// @param points     gives the limit points; must outlive the estimator
    /// @param tolerance  errors are only as exact as a comparison with it needs. 0: all are estimated fully
    /// @param lattice    sqrt(3): of the leaves' forest; must outlive the estimator
    LimitEstimator(const Hierarchy& points, double tolerance, const Sqrt3Lattice* lattice = nullptr)
        : points_(points), tolerance_(tolerance), lattice_(lattice) {}

    using ErrorEstimator::estimate;
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override;
    void estimate_sqrt3(std::span<const Sqrt3Triangle> triangles, std::span<double> errors) const override;

  private:
    const Hierarchy& points_;
    double tolerance_;
    const Sqrt3Lattice* lattice_;
};

}  // namespace tetrakis::detail
