#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/forest/site.hpp"

#include <span>

namespace tetrakis {

/// Gives positions of an adaptive mesh's vertices: a pure function of the site (refine/README.md). Called with large
/// batches, from several threads at once.
class PositionSource {
  public:
    virtual ~PositionSource() = default;
    /// @param sites      canonical sites
    /// @param positions  receives sites.size() positions in the unit and frame of the control mesh
    virtual void positions(std::span<const Site> sites, std::span<Vec3d> positions) const = 0;
};

}  // namespace tetrakis
