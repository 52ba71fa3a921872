#pragma once

#include "../../hier/mesh/fan_choice.hpp"
#include "leaf_estimator.hpp"

namespace tetrakis {

/// Errors of a face's fan (eval/README.md, Coarsest mesh) against the surface of its roots.
class FanError {
  public:
    FanError(const SurfaceMap<QuadFamily>& map, const LeafEstimator<QuadFamily>& estimator, const FanChoice& fans,
             std::span<const Vec3d> corner_positions)
        : map_(map), estimator_(estimator), fans_(fans), positions_(corner_positions) {}

    /// Certified upper bound on the parametric error of the fan, the surface's roots laid over the regular polygon that
    /// its triangles cut: each root against the sector's own flat triangle, plus what the fan departs from those.
    /// Decides at `decide_at`: infinite where the error is certainly larger, unless may_reject is false: then tight.
    double certified(FaceId face, double decide_at, bool may_reject) const;
    struct Estimate {
        double error = 0;
        ErrorBasis basis = ErrorBasis::bound;
    };
    /// What the default estimator goes by: the bound where it accepts; else what samples of the surface are off the
    /// fan's planes, boundary edges against themselves.
    Estimate measured(FaceId face, double tolerance) const;

  private:
    const SurfaceMap<QuadFamily>& map_;
    const LeafEstimator<QuadFamily>& estimator_;
    const FanChoice& fans_;
    std::span<const Vec3d> positions_;  ///< of the control vertices in the output
};

}  // namespace tetrakis
