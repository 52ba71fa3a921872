#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// One half-edge seen as a use of its undirected edge.
struct EdgeUse {
    std::uint32_t low, high;  ///< the edge's vertices, low < high
    std::uint32_t halfedge;

    bool same_edge(const EdgeUse& other) const { return low == other.low && high == other.high; }
};
static_assert(sizeof(EdgeUse) == 12);

/// All half-edges sorted by (low, high, halfedge): uses of one edge are neighbours. Two stable bucket passes over the
/// smaller vertex, then a sort of each vertex's few edges: O(H) for bounded valence, O(H log H) at worst; parallel.
/// @param face_offsets   F + 1 ascending numbers
/// @param face_vertices  H vertex numbers below `vertex_count`, no vertex twice in a row around a face
std::vector<EdgeUse> sorted_edge_uses(std::span<const std::uint32_t> face_offsets,
                                      std::span<const std::uint32_t> face_vertices, std::uint32_t vertex_count);

/// First use of the edge {a, b} in sorted uses, or null. O(log H).
const EdgeUse* find_edge(std::span<const EdgeUse> sorted_uses, std::uint32_t a, std::uint32_t b);

}  // namespace tetrakis::detail
