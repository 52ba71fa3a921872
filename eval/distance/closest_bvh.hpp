#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/base/vec.hpp"

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <type_traits>

namespace tetrakis {

/// Nearest-primitive search over anything that has a bounding box and an exact distance of its own: patches of a limit
/// surface, edges, points. Embree's hierarchy of boxes finds the candidates in float, in a local frame, with boxes and
/// radii rounded outward, so that no candidate is missed; all distances compared are the caller's doubles. The answer
/// is therefore exact and does not depend on the hierarchy: the least distance, among equals the lowest number.
class ClosestBvh {
  public:
    struct Hit {
        std::uint32_t primitive = k_none;
        double distance = std::numeric_limits<double>::infinity();
        bool found() const { return primitive != k_none; }
    };
    static constexpr std::uint32_t k_none = 0xFFFF'FFFFu;

    /// @param box_of  the box of primitive i in [0, count), which holds it; an empty one is never a candidate. Called
    ///                from several threads, several times for each i; what it throws is thrown from here
    /// @throws Error invalid_input: a bound is NaN or infinite; memory_limit (context.max_memory_bytes, Embree's share)
    /// Reports stage "build".
    ClosestBvh(std::uint32_t count, const std::function<Box3d(std::uint32_t)>& box_of, const RunContext& context = {});
    ~ClosestBvh();

    /// The nearest primitive within max_distance (inclusive), or a Hit with found() == false.
    /// @param exact  double exact(primitive, best): distance from `point` to the primitive; may be any larger number
    ///               where it exceeds `best`. What it throws ends the search and is thrown from here. It must not
    ///               query this object's Embree scene with a smaller sphere than it was given.
    /// A good max_distance (a distance known to be reached) saves most of the work. Thread-safe.
    template <class Exact>
    Hit query(const Vec3d& point, double max_distance, Exact&& exact) const {
        using F = std::remove_reference_t<Exact>;
        Search search{point,
                      {k_none, max_distance},
                      const_cast<void*>(static_cast<const void*>(&exact)),
                      [](void* f, std::uint32_t primitive, double best) -> double {
                          return (*static_cast<F*>(f))(primitive, best);
                      }};
        run(search);
        return search.hit;
    }

  private:
    friend struct ClosestBvhCallbacks;
    struct Search {
        Vec3d point;
        Hit hit;  // distance: the best so far
        void* exact;
        double (*call)(void*, std::uint32_t, double);
        std::exception_ptr thrown{};
        double scale = 1, slack = 0;  // of the local frame; what float rounding of the query point may cost in it
    };
    void run(Search& search) const;

    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace tetrakis
