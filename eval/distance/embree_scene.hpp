#pragma once

// Private to eval: the only header that shows Embree.

#include "../../hier/base/error.hpp"
#include "../../hier/base/run_context.hpp"
#include "../surface/local_frame.hpp"

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>

namespace tetrakis::detail {

/// An Embree device with one scene. Embree reports its failures through the device; check() turns them into Errors.
class EmbreeScene {
  public:
    /// @param max_memory_bytes  what Embree may allocate for this scene; 0: no limit
    EmbreeScene(RTCSceneFlags flags, std::uint64_t max_memory_bytes);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    RTCDevice device() const { return device_; }
    RTCScene scene() const { return scene_; }

    /// Attaches the geometry (as number 0), builds the hierarchy and takes over the reference. Reports stage "build".
    /// @throws Error memory_limit, cancelled, or invalid_input with Embree's reason; whatever context.progress throws
    void build(RTCGeometry geometry, const RunContext& context);

    /// Bytes that Embree holds now (the caller's shared buffers not included).
    std::uint64_t memory_bytes() const { return static_cast<std::uint64_t>(bytes_.load()); }

  private:
    static bool on_memory(void* self, ssize_t bytes, bool post);
    static void on_error(void* self, RTCError code, const char* text);

    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    std::atomic<std::int64_t> bytes_ = 0;
    std::int64_t limit_ = 0;
    std::atomic<int> failure_ = RTC_ERROR_NONE;
};

// Embree computes squared box distances in float: one rounding in each difference of coordinates, five in squares and
// sum, one in the squared radius; together below 8 * 2^-24 relative in the square, 2^-22 in the distance. Four times
// that also covers the double roundings of the local frame.
inline constexpr double k_radius_inflation = 0x1p-20;

// Squares and sums of local coordinates up to this stay finite in float.
inline constexpr double k_farthest_float_query = 0x1p60;

/// A float radius that misses nothing within `distance` (in local units) of the exact query point, when `slack` bounds
/// how far float rounding moved the query point and the primitives.
inline float search_radius(double distance, double slack) {
    const double radius = (distance + slack) * (1 + k_radius_inflation);
    // The square must not underflow to zero, or a primitive that touches the point would be culled.
    constexpr double k_smallest = 0x1p-60;
    return radius < std::numeric_limits<float>::max() ? round_up(std::max(radius, k_smallest))
                                                      : std::numeric_limits<float>::infinity();
}

}  // namespace tetrakis::detail
