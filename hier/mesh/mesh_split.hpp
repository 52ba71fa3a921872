#pragma once

#include "control_mesh.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Result of split_to_manifold().
struct ManifoldSplit {
    std::vector<std::uint32_t> origin;  ///< for each vertex, its old number; copies come last
    std::uint64_t non_manifold_edges = 0, split_vertices = 0, flipped_faces = 0, cut_faces = 0;
    std::array<std::uint32_t, 2> first_edge{};  ///< vertices of the first edge of more than two faces
    std::uint32_t first_vertex = 0;             ///< first vertex that was split
};

/// Splits vertices and flips faces until the data is an oriented 2-manifold with boundary. An edge of more than two
/// faces connects none of them. A vertex gets a copy for each fan of connected faces around it. Faces get the same
/// orientation across the remaining edges; if that is impossible (a Moebius strip), a face is cut off from its
/// neighbours at such an edge. Positions, face_vertices and corner layers change; tags do not. Each face must be sound
/// by itself (without faults of a single face).
ManifoldSplit split_to_manifold(ControlMeshData& data);

}  // namespace tetrakis::detail
