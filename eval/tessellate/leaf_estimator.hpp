#pragma once

#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/families/error_estimator.hpp"
#include "../triangles/point_triangle.hpp"
#include "surface_map.hpp"
#include "tessellate.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <atomic>

namespace tetrakis {

/// The two estimators of eval/README.md for leaves of one family.
///
/// certified: the certified bound itself. measured: the bound where it accepts; else the deviation of samples from the
/// triangle's plane (two-sided, see PlaneMeasure), at a local maximum near the tolerance; Newton's method for a closest
/// point where tangential drift makes the way back doubtful; ever more samples towards creases of finite sharpness.
/// Edges on boundaries and hard creases are measured against themselves. With a target mesh or a displacement
/// everything is sampled; against a target also by rays along the normal.
template <class Family>
class LeafEstimator final : public ErrorEstimator {
  public:
    /// @param compares  errors above the tolerance are compared with each other; else it is enough that they are larger
    LeafEstimator(const SurfaceMap<Family>& map, EstimatorKind kind, double tolerance, bool compares = false);

    /// From one thread at a time: on the way trees of the patches may be forgotten.
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors,
                  std::span<ErrorBasis> basis) const override;
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override;

    bool compares() const { return compares_; }
    /// Some leaf of a mapped surface could not be resolved: see mapped().
    bool gave_up() const { return gave_up_.load(std::memory_order_relaxed); }
    /// The calling thread's bounder.
    typename Family::Bounder& bounder() const { return bounders_.local(); }
    /// The edges that the surface may cross: neither on a boundary nor on a hard crease.
    std::array<bool, 3> soft_edges(const CellTriangle& leaf) const {
        const std::array<bool, 3> hard = hard_edges<Family>(map_.patches->mesh(), leaf);
        return {!hard[0], !hard[1], !hard[2]};
    }

  private:
    double sampled(const CellTriangle& leaf) const;
    /// Leaves much smaller than the tolerance are left as they are: there the map jumps, and refining would never end.
    double mapped(const CellTriangle& leaf) const;

    const SurfaceMap<Family>& map_;
    EstimatorKind kind_;
    double tolerance_;
    bool compares_;
    mutable std::atomic<bool> gave_up_ = false;
    mutable oneapi::tbb::enumerable_thread_specific<typename Family::Bounder> bounders_;
};

/// Errors of a face's fan (eval/README.md, Coarsest mesh) against the surface of its roots.
class FanError {
  public:
    FanError(const SurfaceMap<QuadFamily>& map, const LeafEstimator<QuadFamily>& estimator, const FanChoice& fans,
             std::span<const Vec3d> corner_positions)
        : map_(map), estimator_(estimator), fans_(fans), positions_(corner_positions) {}

    /// Certified upper bound on the error of the fan: each root against a flat triangle over its sector of the regular
    /// polygon that the fan's triangles cut, plus what the fan departs from those triangles.
    /// Decides at `decide_at`: infinite where the error is certainly larger, unless may_reject is false: then tight.
    double certified(FaceId face, double decide_at, bool may_reject) const;
    /// What the default estimator goes by: the bound where it accepts; else what samples of the surface are off the
    /// fan's planes, boundary edges against themselves.
    double measured(FaceId face, double tolerance) const;

  private:
    const SurfaceMap<QuadFamily>& map_;
    const LeafEstimator<QuadFamily>& estimator_;
    const FanChoice& fans_;
    std::span<const Vec3d> positions_;  ///< of the control vertices in the output
};

}  // namespace tetrakis
