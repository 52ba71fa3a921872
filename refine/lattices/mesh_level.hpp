#pragma once

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Connectivity of a mesh of quads or of triangles as flat arrays. Half-edges are face corners in face order; what
/// arithmetic gives (next, prev, face) is not stored.
struct MeshLevel {
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;

    std::uint32_t face_size = 4;  ///< 3 or 4
    std::uint32_t vertex_count = 0, edge_count = 0, face_count = 0;

    std::vector<std::uint32_t> origin;           ///< H
    std::vector<std::uint32_t> twin;             ///< H; none on the boundary
    std::vector<std::uint32_t> edge_side;        ///< H; 2 e, plus 1 when h is not the edge's first half-edge
    std::vector<std::uint32_t> edge_halfedge;    ///< E; the edge's first half-edge
    std::vector<std::uint32_t> vertex_halfedge;  ///< V; outgoing; at a boundary the one without twin; none if isolated

    std::uint32_t halfedge_count() const { return static_cast<std::uint32_t>(origin.size()); }
    std::uint32_t face_of(std::uint32_t h) const { return face_size == 4 ? h / 4 : h / 3; }
    std::uint32_t next(std::uint32_t h) const {
        if (face_size == 4) return (h & ~3u) | ((h + 1) & 3u);
        return h % 3 == 2 ? h - 2 : h + 1;
    }
    std::uint32_t prev(std::uint32_t h) const {
        if (face_size == 4) return (h & ~3u) | ((h + 3) & 3u);
        return h % 3 == 0 ? h + 2 : h - 1;
    }
    std::uint32_t first_halfedge(std::uint32_t face) const { return face * face_size; }
    std::uint32_t edge(std::uint32_t h) const { return edge_side[h] >> 1; }
};

}  // namespace tetrakis::detail
