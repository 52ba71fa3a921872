#pragma once

#include "control_mesh.hpp"

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// A half-edge, seen as a use of its undirected edge.
struct EdgeUse {
    std::uint32_t low, high;  ///< the edge's vertices, low < high
    std::uint32_t halfedge;

    bool same_edge(const EdgeUse& other) const { return low == other.low && high == other.high; }
    friend auto operator<=>(const EdgeUse&, const EdgeUse&) = default;
};
static_assert(sizeof(EdgeUse) == 12);

/// The next and the previous corner of a face.
inline std::uint32_t next_corner(const ControlMeshData& data, std::uint32_t face, std::uint32_t h) {
    return h + 1 == data.face_offsets[face + 1] ? data.face_offsets[face] : h + 1;
}
inline std::uint32_t prev_corner(const ControlMeshData& data, std::uint32_t face, std::uint32_t h) {
    return (h == data.face_offsets[face] ? data.face_offsets[face + 1] : h) - 1;
}

/// All half-edges sorted by (low, high, halfedge), so uses of one edge follow one another. A stable counting pass over
/// the smaller vertex, then a sort of the few edges of each vertex: O(H) for bounded valence, O(H log H) at worst. The
/// faces must be sound.
std::vector<EdgeUse> sorted_edge_uses(std::span<const std::uint32_t> face_offsets,
                                      std::span<const std::uint32_t> face_vertices, std::uint32_t vertex_count);
inline std::vector<EdgeUse> sorted_edge_uses(const ControlMeshData& data) {
    return sorted_edge_uses(data.face_offsets, data.face_vertices, static_cast<std::uint32_t>(data.positions.size()));
}

/// First use of the edge {a, b} in sorted uses, or null. O(log H).
const EdgeUse* find_edge(std::span<const EdgeUse> sorted_uses, std::uint32_t a, std::uint32_t b);

/// The connections of a mesh's corners. They exist for any mesh with sound faces; only if each edge has at most two
/// uses, in opposite directions, do the twins describe a surface.
struct MeshLinks {
    std::vector<std::uint32_t> face;               ///< H: the half-edge's face
    std::vector<std::uint32_t> twin;               ///< H: the edge's other use if it has exactly two, else none
    std::vector<std::uint32_t> vertex_halfedge;    ///< V: as ControlMesh::vertex_halfedge
    std::vector<std::uint32_t> vertex_face_count;  ///< V: corners at the vertex
    bool manifold_edges = true;                    ///< no edge has more than two uses, or two of one direction
};

/// O(H). @param sorted_uses  sorted_edge_uses() of the same faces
MeshLinks link_mesh(const ControlMeshData& data, std::span<const EdgeUse> sorted_uses);

}  // namespace tetrakis::detail
