#pragma once

#include "../base/ids.hpp"
#include "../base/memory.hpp"
#include "../base/parallel.hpp"
#include "site.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetrakis {

/// Leaves that a change of a forest has created or reshaped.
struct ForestChange {
    std::vector<LeafId> created;   ///< new: children of split leaves, siblings together; parents of merged leaves
    std::vector<LeafId> reshaped;  ///< older leaves that remain, but whose output triangles have changed
};

/// The output mesh of a forest, in (root, path) order. Except for `leaves` and `points` it depends on the set of leaves
/// alone, not on the changes that led to this set.
struct ExportedTriangles {
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< corners: numbers into `sites`, counter-clockwise
    std::vector<FaceId> faces;                            ///< per triangle: its control face
    std::vector<Site> sites;                              ///< per point, in order of first use: its canonical site
    std::vector<LeafId> leaves;                           ///< per triangle: its leaf; invalid for a fan's triangles
    std::vector<PointId> points;                          ///< per point: its handle in the forest
};

namespace detail {

/// Replaces the point handles in `out.triangles` by numbers in the order of first use; fills `points` and `sites`.
/// @param expected  number of points, about
/// O(point slots + triangles).
template <class Forest>
void number_points(ExportedTriangles& out, const Forest& forest, std::size_t expected) {
    constexpr std::size_t k_ahead = 16;  // prefetch distance in triangles: the loop waits for memory
    PoolVector<std::uint32_t> numbers(forest.point_slots(), PointId::none);
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
    resize_large(out.sites, out.points.size());
    for_each_index(static_cast<std::uint32_t>(out.points.size()),
                   [&](std::uint32_t i) { out.sites[i] = forest.point_site(out.points[i]); });
}

}  // namespace detail

}  // namespace tetrakis
