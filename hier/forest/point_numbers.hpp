#pragma once

#include "../base/memory.hpp"
#include "exported_triangles.hpp"

#include <cstddef>
#include <cstdint>

namespace tetrakis::detail {

/// Replaces the triangles' points by numbers in the order of first use, and lists the points by these.
/// @param out       ExportedTriangles or PooledTriangles
/// @param slots     points are below this
/// @param expected  how many there are, about
/// O(slots + triangles), one thread.
template <class Exported>
void number_points(Exported& out, std::size_t slots, std::size_t expected) {
    constexpr std::size_t k_ahead =
        16;  // triangles whose points are asked for ahead of time: the loop waits for memory
    PoolVector<std::uint32_t> numbers(slots, PointId::none);
    reserve_large(out.points, expected);
    const std::size_t count = out.triangles.size();
    for (std::size_t t = 0; t < count; ++t) {
        if (t + k_ahead < count)
            for (std::uint32_t p : out.triangles[t + k_ahead]) __builtin_prefetch(&numbers[p]);
        for (std::uint32_t& p : out.triangles[t]) {
            std::uint32_t& number = numbers[p];
            if (number == PointId::none) {
                number = static_cast<std::uint32_t>(out.points.size());
                out.points.push_back(PointId(p));
            }
            p = number;
        }
    }
}

}  // namespace tetrakis::detail
