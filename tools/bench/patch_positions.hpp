#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/refine/adaptive.hpp"

#include <span>

namespace tetrakis::bench {

/// Limit positions by a patch tree.
template <class Patches>
class PatchPositions final : public PositionSource {
  public:
    explicit PatchPositions(const ControlMesh& mesh) : patches_(mesh) {}
    void positions(std::span<const Site> sites, std::span<Vec3d> out) const override {
        for_each_index(
            static_cast<std::uint32_t>(sites.size()),
            [&](std::uint32_t i) { out[i] = patches_.limit(sites[i].root, sites[i].at, sites[i].level); }, 256);
    }

  private:
    Patches patches_;
};

}  // namespace tetrakis::bench
