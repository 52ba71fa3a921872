#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../../refine/families/error_estimator.hpp"

#include <array>
#include <span>
#include <vector>

namespace tetrakis {

/// Certified errors of triangles over a limit surface: no point of one is farther from the other. Where a bound aims at
/// an error, estimate() gives lower bounds above it.
class SurfaceBound : public ErrorEstimator {
  public:
    /// Whether there may be a bound for the fan of such a face.
    virtual bool has_fan_bound(FaceId face) const = 0;
    /// Of faces that are cut along diagonals (eval/README.md, Coarsest mesh).
    /// @param corners  of the mesh, by control vertex
    /// @param out      receives faces.size() errors as estimate() gives them; infinite where there is no bound
    virtual void estimate_fans(const FanChoice& fans, std::span<const FaceId> faces, std::span<const Vec3d> corners,
                               std::span<double> out) const = 0;
    /// The largest of the triangles' errors and of `known`; tight to a twentieth where it exceeds that and the aim.
    virtual double largest(std::span<const CellTriangle> triangles, double known) const = 0;
    /// The same of faces that are cut along diagonals; infinite where one has no bound.
    virtual double largest_of_fans(const FanChoice& fans, std::span<const FaceId> faces, std::span<const Vec3d> corners,
                                   double known) const = 0;
};

}  // namespace tetrakis
