#pragma once

#include "control_mesh.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// What split_to_manifold() did.
struct ManifoldSplit {
    std::vector<std::uint32_t> origin;  ///< for each vertex now, the vertex it was before; copies come at the end
    std::uint64_t non_manifold_edges = 0, split_vertices = 0, flipped_faces = 0, cut_faces = 0;
    std::array<std::uint32_t, 2> first_edge{};  ///< vertices of the first edge of more than two faces
    std::uint32_t first_vertex = 0;             ///< first vertex that was split
};

/// Splits vertices and flips faces until the data is an oriented 2-manifold with boundary. An edge of more than two
/// faces holds none of them together; a vertex gets a copy for each fan of faces that hang together around it; faces
/// are turned alike over the edges that are left. Where that is impossible (a Moebius strip), a face is cut loose from
/// its neighbours at the offending edge. Positions, face_vertices and corner layers change; tags do not. The faces must
/// be sound by themselves (no fault of a single face).
ManifoldSplit split_to_manifold(ControlMeshData& data);

}  // namespace tetrakis::detail
