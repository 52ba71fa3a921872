#pragma once

#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/families/error_estimator.hpp"
#include "../triangles/point_triangle.hpp"
#include "surface_map.hpp"
#include "tessellate.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <atomic>

namespace tetrakis::detail {

/// The two estimators of eval/README.md for leaves of one family.
///
/// certified: the certified bound itself. measured: the bound if it accepts the leaf; else distances of samples to the
/// triangle (two-sided, see PlaneMeasure). Samples near the tolerance climb to a local maximum; samples are denser near
/// creases of finite sharpness. Points of the triangle that lie far from their own sample get a closest point by
/// Newton's method. Edges on boundaries and hard creases are compared with the surface's own edge curve. With a target
/// or a displacement all leaves are sampled; with a target, rays along the triangle's normal are cast, too.
template <class Family>
class LeafEstimator final : public ErrorEstimator {
  public:
    /// @param compares  errors above `tolerance` must be comparable with each other; else they need only exceed it
    LeafEstimator(const SurfaceMap<Family>& map, EstimatorKind kind, double tolerance, bool compares = false);

    /// Call it from one thread at a time: it may free memory of the patches (their trees).
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors,
                  std::span<ErrorBasis> basis) const override;
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override;

    bool compares() const { return compares_; }
    /// Whether some leaf of a mapped surface was accepted with an error above the tolerance: see mapped().
    bool gave_up() const { return gave_up_.load(std::memory_order_relaxed); }
    /// The calling thread's bounder.
    typename Family::Bounder& bounder() const { return bounders_.local(); }
    /// Which edges of the leaf lie neither on a boundary nor on a hard crease: the surface continues across them.
    std::array<bool, 3> soft_edges(const CellTriangle& leaf) const {
        const std::array<bool, 3> hard = hard_edges<Family>(map_.patches->mesh(), leaf);
        return {!hard[0], !hard[1], !hard[2]};
    }

  private:
    double sampled(const CellTriangle& leaf) const;
    /// Leaves much smaller than the tolerance are accepted: the map jumps there, and refining them would never end.
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

    /// Certified upper bound on the error of the fan, a sum of two bounds: of each root against the flat triangle from
    /// its edge to a centre, and of these triangles against the fan. If there are at most four, they lie in the fan;
    /// else both are compared with the flattened face, where that is convex.
    /// @param may_reject  the result is infinite if the error is certainly above `decide_at`; else the bound is tight
    double certified(FaceId face, double decide_at, bool may_reject) const;
    /// Error for the measured estimator: the bound if it is within `tolerance`. Else it is the largest distance of
    /// surface samples to the fan's triangles, or of samples on hard edges to the fan's own edges.
    double measured(FaceId face, double tolerance) const;

  private:
    const SurfaceMap<QuadFamily>& map_;
    const LeafEstimator<QuadFamily>& estimator_;
    const FanChoice& fans_;
    std::span<const Vec3d> positions_;  ///< output positions of the control vertices
};

}  // namespace tetrakis::detail
