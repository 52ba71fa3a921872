#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/corner_cell.hpp"

#include <span>

namespace tetrakis::detail {

/// The limit surface of a scheme over the lattice of a SampledSurface.
class LatticeLimits {
  public:
    virtual ~LatticeLimits() = default;
    /// Limit positions and unit normals of sites of the roots.
    virtual void points(std::span<const Site> sites, std::span<Vec3d> positions, std::span<Vec3d> normals) const = 0;
    /// How far the limit surface is at most from each of these finest triangles of one corner cell, or from those
    /// around it.
    virtual void bound(std::span<const CellTriangle> triangles, std::span<double> errors) const = 0;
};

}  // namespace tetrakis::detail
