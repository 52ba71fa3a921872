#pragma once

#include "control_mesh.hpp"
#include "edge_uses.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// How the corners of a mesh hang together. Holds for any mesh whose faces are sound; only where each edge has at most
/// two uses, of opposite direction, do the twins mean a surface.
struct MeshLinks {
    std::vector<std::uint32_t> face;               ///< H: the half-edge's face
    std::vector<std::uint32_t> twin;               ///< H: the edge's other use where it has exactly two, else none
    std::vector<std::uint32_t> vertex_halfedge;    ///< V: as ControlMesh::vertex_halfedge
    std::vector<std::uint32_t> vertex_face_count;  ///< V: corners at the vertex
    bool manifold_edges = true;                    ///< no edge has more than two uses, or two of one direction
};

/// O(H), parallel. @param sorted_uses  sorted_edge_uses() of the same faces
MeshLinks link_mesh(const ControlMeshData& data, std::span<const EdgeUse> sorted_uses);

/// Number of corners met by walking counter-clockwise from the vertex's first half-edge; fewer than its face count
/// means a non-manifold vertex. Valid where every edge is manifold and consistently oriented.
std::uint32_t fan_size(const ControlMeshData& data, const MeshLinks& links, std::uint32_t vertex);

}  // namespace tetrakis::detail
