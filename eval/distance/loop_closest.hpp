#pragma once

#include "../surface/loop_patches.hpp"
#include "../surface/surface_parameter.hpp"
#include "closest_bvh.hpp"

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace tetrakis {

/// Closest points on a Loop limit surface; as QuadClosest.
class LoopClosest {
  public:
    explicit LoopClosest(const LoopPatches& patches) : patches_(patches) {}

    /// Builds the boxes of global(), with progress and within the memory limit, unless they are there.
    /// @throws Error memory_limit, cancelled
    void prepare(const RunContext& context) const;
    /// Distance from q to a nearby point of the surface: Gauss-Newton from `start`, across triangles, not across the
    /// boundary. Never more than the distance to the start. An upper bound of the distance to the surface.
    double local(const Vec3d& q, SurfaceParameter start) const;
    /// Distance from q to the surface if it is less than `best`, else `best`. Looks at all boxes at first, in a
    /// hierarchy of them when it is asked more often or prepare() was called.
    double global(const Vec3d& q, double best) const;

  private:
    const std::vector<Box3d>& boxes() const;
    double in_root(const Vec3d& q, HalfedgeId root, double best) const;

    const LoopPatches& patches_;
    mutable std::once_flag boxed_, built_;
    mutable std::atomic<std::uint64_t> searches_{0};
    mutable std::vector<Box3d> boxes_;
    mutable std::unique_ptr<ClosestBvh> bvh_;
};

}  // namespace tetrakis
