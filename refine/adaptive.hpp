#pragma once

#include "tetrakis/hier/site.hpp"
#include "tetrakis/hier/vec.hpp"

#include <span>

namespace tetrakis {

/// Gives the positions of an adaptive mesh's vertices: a pure function of the site (DESIGN 3.3). Called with large
/// batches, from several threads at once.
class PositionSource {
  public:
    virtual ~PositionSource() = default;
    /// @param sites      canonical sites
    /// @param positions  receives sites.size() positions in the unit and frame of the control mesh
    virtual void positions(std::span<const Site> sites, std::span<Vec3d> positions) const = 0;
};

/// Decides where to refine: gives each triangle an error, in the unit of the control mesh, to be compared with the
/// tolerance. Called with large batches, from several threads at once; an error depends on its triangle alone.
class ErrorEstimator {
  public:
    virtual ~ErrorEstimator() = default;
    /// @param triangles  triangles of the hierarchy (CellTriangle; quad family: depth-0 ones in their extended frame)
    /// @param errors     receives triangles.size() errors
    virtual void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const = 0;
};

}  // namespace tetrakis
