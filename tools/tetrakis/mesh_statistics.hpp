#pragma once

#include "../../hier/mesh/control_mesh.hpp"

#include <cstdint>
#include <map>

namespace tetrakis::cli {

/// What there is to know about a control mesh at a glance.
struct MeshStatistics {
    std::map<std::uint32_t, std::uint64_t> faces_by_size;
    std::map<std::uint32_t, std::uint64_t> interior_vertices_by_valence;
    std::uint64_t boundary_edges = 0, boundary_loops = 0;
    std::uint64_t pieces = 0;  ///< connected components
    std::int64_t euler_characteristic = 0;
    std::uint64_t sharp_edges = 0, semi_sharp_edges = 0;        ///< inside the surface; the boundary is not counted
    std::uint64_t sharp_vertices = 0, semi_sharp_vertices = 0;  ///< tagged as corners
    std::uint64_t holes = 0, isolated_vertices = 0;
};

/// O(H).
MeshStatistics statistics(const ControlMesh& mesh);

}  // namespace tetrakis::cli
