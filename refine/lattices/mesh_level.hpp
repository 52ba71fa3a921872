#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Connectivity and tags of the base of uniform refinement, the control mesh or its first refinement into quads, as
/// flat arrays. Half-edges are face corners in face order; what arithmetic gives (next, prev, face) is not stored.
struct MeshLevel {
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;

    int face_size =
        0;  ///< where all faces have the same: 3 or 4; else 0, and the control mesh's own face offsets count
    const ControlMesh* control = nullptr;
    std::uint32_t vertex_count = 0, edge_count = 0, face_count = 0;

    std::vector<std::uint32_t> origin;           ///< H
    std::vector<std::uint32_t> twin;             ///< H; none on the boundary
    std::vector<std::uint32_t> edge_side;        ///< H; 2 e, plus 1 when h is not the edge's first half-edge
    std::vector<std::uint32_t> edge_halfedge;    ///< E; the edge's first half-edge
    std::vector<std::uint32_t> vertex_halfedge;  ///< V; outgoing; at a boundary the one without twin; none if isolated

    // Tags; empty when the mesh has none that is sharp (no boundary either).
    std::vector<float> edge_sharpness;    ///< E
    std::vector<float> vertex_sharpness;  ///< V
    std::vector<std::uint8_t> tagged;     ///< V; the vertex or one of its edges is sharp

    std::uint32_t halfedge_count() const { return static_cast<std::uint32_t>(origin.size()); }
    std::uint32_t face_of(std::uint32_t h) const {
        if (face_size == 4) return h / 4;
        if (face_size == 3) return h / 3;
        return control->face(HalfedgeId(h)).value;
    }
    std::uint32_t next(std::uint32_t h) const {
        if (face_size == 4) return (h & ~3u) | ((h + 1) & 3u);
        if (face_size == 3) return h % 3 == 2 ? h - 2 : h + 1;
        return control->next(HalfedgeId(h)).value;
    }
    std::uint32_t prev(std::uint32_t h) const {
        if (face_size == 4) return (h & ~3u) | ((h + 3) & 3u);
        if (face_size == 3) return h % 3 == 0 ? h + 2 : h - 1;
        return control->prev(HalfedgeId(h)).value;
    }
    std::uint32_t first_halfedge(std::uint32_t face) const {
        return face_size != 0 ? face * static_cast<std::uint32_t>(face_size) : control->data().face_offsets[face];
    }
    std::uint32_t size_of(std::uint32_t face) const {
        return face_size != 0 ? static_cast<std::uint32_t>(face_size) : control->face_size(FaceId(face));
    }
    std::uint32_t edge(std::uint32_t h) const { return edge_side[h] >> 1; }
    bool has_tags() const { return !edge_sharpness.empty(); }
};

/// Level 0: the control mesh.
MeshLevel control_level(const ControlMesh& mesh);

/// The first refinement, of any faces into quads. With V, E, F, H elements of the control mesh:
///
/// * vertices: the V old ones, then one per face, then one per edge, each in the order of its parents;
/// * edges: 2e + s is the half of edge e at the origin (s = 0) or target (s = 1) of its first half-edge; then
///   2E + h runs from the midpoint of h to its face point;
/// * faces: quad h for half-edge h: [origin, midpoint of h, face point, midpoint of prev(h)].
///
/// So all of it is found by arithmetic; nothing is sorted or hashed.
MeshLevel refine_to_quads(const MeshLevel& control, CreaseMethod method);

/// Elements of level l: counts grow too fast for 32 bits, so they are known before anything is made.
struct LevelCounts {
    std::uint64_t vertices = 0, edges = 0, faces = 0, halfedges = 0;
};
LevelCounts next_counts(const LevelCounts& counts, SchemeKind scheme);

}  // namespace tetrakis::detail
