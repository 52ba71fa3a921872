#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/families/error_estimator.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis {

/// Certified errors of triangles over a limit surface: no point of one is farther from the other. Where a bound aims at
/// an error, estimate() gives lower bounds above it.
class SurfaceBound : public ErrorEstimator {
  public:
    using ErrorEstimator::estimate;
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override {
        bound(triangles, {}, errors);
    }
    /// @param known  of a larger error: all are tight to a twentieth where they exceed that and the aim. Else errors
    ///               are as estimate() gives them
    virtual void bound(std::span<const CellTriangle> triangles, std::optional<double> known,
                       std::span<double> errors) const = 0;
    /// Of faces that are cut along diagonals (eval/README.md, Coarsest mesh); infinite where there is no bound.
    /// @param corners  of the mesh, by control vertex
    virtual void bound_fans(const FanChoice& fans, std::span<const FaceId> faces, std::span<const Vec3d> corners,
                            std::optional<double> known, std::span<double> errors) const = 0;
};

}  // namespace tetrakis
