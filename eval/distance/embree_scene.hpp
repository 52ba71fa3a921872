#pragma once

// Private to eval: the only header that shows Embree.

#include "../../hier/base/error.hpp"
#include "../../hier/base/run_context.hpp"
#include "../surface/local_frame.hpp"

#include <embree3/rtcore.h>

#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <type_traits>

namespace tetrakis::detail {

/// An Embree device with one scene of one geometry. Embree reports its failures through the device; build() turns them
/// into Errors.
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

    /// The distance of the nearest primitive, or max_distance where none is nearer. Embree finds candidates in float,
    /// with radii rounded outward, so that none is missed, equal ones neither; the distances compared are the caller's.
    /// Thread-safe.
    /// @param frame     of the geometry's coordinates
    /// @param count     primitives
    /// @param rounding  what the geometry's rounding to float may move, as a share of the point's local coordinates
    /// @param exact     double exact(primitive, best): its distance from `point`; may be any larger number where it
    ///                  exceeds `best`. What it throws ends the search and is thrown from here
    template <class Exact>
    double nearest(const LocalFrame& frame, std::uint32_t count, double rounding, const Vec3d& point,
                   double max_distance, Exact&& exact) const {
        Search search{max_distance, const_cast<void*>(static_cast<const void*>(std::addressof(exact))),
                      [](void* f, std::uint32_t primitive, double best) -> double {
                          return (*static_cast<std::remove_reference_t<Exact>*>(f))(primitive, best);
                      },
                      frame.scale};
        run(search, frame.to_local(point), count, rounding);
        return search.distance;
    }

    /// Bytes that Embree holds now (the caller's shared buffers not included).
    std::uint64_t memory_bytes() const { return static_cast<std::uint64_t>(bytes_.load()); }

  private:
    struct Search {
        double distance;  ///< the least so far
        void* exact;
        double (*call)(void*, std::uint32_t, double);
        double scale;      ///< of the local frame
        double slack = 0;  ///< in it: how far float rounding moved the query point and the primitives
        std::exception_ptr thrown{};

        /// Returns whether this primitive is nearer than those before.
        bool offer(std::uint32_t primitive);
        /// A float radius that misses nothing as near as what has been found.
        float radius() const;
    };
    void run(Search& search, const Vec3d& local, std::uint32_t count, double rounding) const;
    static bool on_candidate(RTCPointQueryFunctionArguments* args);
    static bool on_memory(void* self, ssize_t bytes, bool post);
    static void on_error(void* self, RTCError code, const char* text);

    RTCDevice device_ = nullptr;
    RTCScene scene_ = nullptr;
    std::atomic<std::int64_t> bytes_ = 0;
    std::int64_t limit_ = 0;
    std::atomic<int> failure_ = RTC_ERROR_NONE;
};

// Squares and sums of local coordinates up to this stay finite in float.
inline constexpr double k_farthest_float_query = 0x1p60;

}  // namespace tetrakis::detail
