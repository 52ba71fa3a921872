#pragma once

#include "../loop_patches/loop_patches.hpp"
#include "../patches/quad_patches.hpp"
#include "../surface/surface_point.hpp"

#include <memory>
#include <mutex>

namespace tetrakis {

/// Closest points on a limit surface: Newton's method from a given start, or a search of all roots by Embree's boxes
/// with Newton in each candidate. Thread-safe.
template <class Patches>
class LimitClosest {
  public:
    explicit LimitClosest(const Patches& patches);
    ~LimitClosest();

    /// Builds the boxes of global(), with progress and within the memory limit, unless they are there.
    /// @throws Error memory_limit, cancelled
    void prepare(const RunContext& context) const;
    /// Distance from q to a nearby point of the surface: Gauss-Newton from `start`, across roots, not across the
    /// boundary. Never more than the distance to the start. An upper bound of the distance to the surface.
    double local(const Vec3d& q, SurfaceParameter start) const;
    /// Distance from q to the surface if it is less than `best`, else `best`. Builds the boxes at its first call,
    /// unless prepare() did.
    double global(const Vec3d& q, double best) const;

  private:
    const Patches& patches_;
    double rounding_;  ///< of positions
    mutable std::once_flag built_;
    struct Boxes;
    mutable std::unique_ptr<Boxes> boxes_;
};

using QuadClosest = LimitClosest<QuadPatches>;
using LoopClosest = LimitClosest<LoopPatches>;

}  // namespace tetrakis
