#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/families/error_estimator.hpp"

#include <optional>
#include <span>

namespace tetrakis {

/// Certified errors of triangles over a limit surface: no point of either is farther from the other than the error. If
/// the bound has an aim, errors from estimate() that are above the aim are lower bounds.
class SurfaceBound : public ErrorEstimator {
  public:
    using ErrorEstimator::estimate;
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override {
        bound(triangles, {}, errors);
    }
    /// @param known  if set: all errors are upper bounds, and tight to a twentieth above both `known` and the aim. Else
    ///               errors are as in estimate()
    virtual void bound(std::span<const CellTriangle> triangles, std::optional<double> known,
                       std::span<double> errors) const = 0;
    /// Errors of faces that are cut along diagonals (eval/README.md, Coarsest mesh); infinite if there is no bound.
    /// @param corners  positions of the mesh's corners, by control vertex
    virtual void bound_fans(const FanChoice& fans, std::span<const FaceId> faces, std::span<const Vec3d> corners,
                            std::optional<double> known, std::span<double> errors) const = 0;
};

}  // namespace tetrakis
