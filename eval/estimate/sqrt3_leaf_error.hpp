#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <unordered_map>
#include <vector>

namespace tetrakis::detail {

/// How far the limit surface is from the leaves of an adaptive sqrt(3) mesh: by the limit points that later steps put
/// on a leaf's edges, which two steps cut in three, and inside. An error depends on its leaf alone, and is kept. No
/// bound: what lies between the points can be farther.
class Sqrt3LeafErrors {
  public:
    /// @param lattice  that of the forest of the leaves
    explicit Sqrt3LeafErrors(const Sqrt3Lattice& lattice) : lattice_(lattice) {}

    /// Steps beyond a leaf's level whose points are looked at: the lattice must have as many more.
    static constexpr int k_steps_beyond = 6;

    /// Per leaf the distance of those points to the triangle as PlaneMeasure takes it, along sharp edges to its own
    /// edge: of those two or three steps down where that is above `decide_at`, else of more.
    /// @param decide_at  the same in all calls
    std::vector<double> errors(std::span<const Sqrt3Leaf> leaves, double decide_at,
                               const std::function<void(double)>& report);

  private:
    struct Key {
        std::uint64_t face;
        std::uint8_t level;
        bool half;
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct Hash {
        std::size_t operator()(const Key& k) const noexcept {
            const std::uint64_t h = (k.face ^ std::uint64_t{k.level} << 57 ^ std::uint64_t{k.half} << 56);
            return static_cast<std::size_t>(h * 0x9E37'79B9'7F4A'7C15ull >> 7);
        }
    };

    Sqrt3Lattice lattice_;  // has found nothing: copied
    std::unordered_map<Key, double, Hash> known_;
};

}  // namespace tetrakis::detail
