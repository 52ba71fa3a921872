#include "uniform_cost.hpp"

#include "../../hier/base/error.hpp"
#include "mesh_level.hpp"

#include <algorithm>
#include <limits>
#include <string>

namespace tetrakis::detail {

bool all_quads(const ControlMesh& mesh) {
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (mesh.face_size(FaceId(f)) != 4) return false;
    return true;
}

UniformCost uniform_cost(const ControlMesh& mesh, const UniformDemand& demand) {
    if (demand.levels < 0) throw Error(ErrorCode::invalid_input, "the number of levels is negative");
    if (demand.scheme == SchemeKind::loop && !mesh.all_triangles())
        throw Error(ErrorCode::invalid_input, "Loop subdivision needs a mesh of triangles; triangulate it first",
                    mesh.data().source);
    LevelCounts counts{mesh.vertex_count(), mesh.edge_count(), mesh.face_count(), mesh.halfedge_count()}, before{};
    // Face corners are numbered in 32 bits.
    constexpr std::uint64_t k_most = std::numeric_limits<std::uint32_t>::max();
    for (int level = 0;; ++level) {
        if (counts.halfedges >= k_most || counts.vertices >= k_most)
            throw Error(ErrorCode::unsupported,
                        std::to_string(demand.levels) + " levels give more elements than 32-bit " +
                            "numbers can count; level " + std::to_string(level) + " has " +
                            std::to_string(counts.halfedges) + " face corners",
                        mesh.data().source);
        if (level == demand.levels) break;
        before = counts;
        counts = next_counts(counts, demand.scheme);
    }
    UniformCost cost{counts.vertices, counts.faces, counts.halfedges, 0};
    const std::uint64_t point = 3 * static_cast<std::uint64_t>(demand.scalar_bytes);
    const bool rings = demand.limit || demand.normals;
    // The result: points, normals, corners; the net below a limit; the two levels above; the base and its tags.
    cost.bytes = point * counts.vertices * (1 + (demand.normals ? 1 : 0) + (rings ? 1 : 0)) + 4 * counts.halfedges +
                 point * (before.vertices + before.vertices / 4);
    constexpr std::uint64_t k_base_bytes = 160;  // per half-edge: links, tags, the first refinement of n-gons
    cost.bytes += k_base_bytes * mesh.halfedge_count();
    if (demand.uvs) cost.bytes += (24 + 16) * counts.vertices + 24 * before.vertices + 4 * counts.halfedges;
    return cost;
}

void check_memory(const ControlMesh& mesh, int levels, const UniformCost& cost, const RunContext& context) {
    const std::uint64_t limit = context.max_memory_bytes;
    if (limit == 0 || cost.bytes <= limit) return;
    throw Error(ErrorCode::memory_limit,
                std::to_string(levels) + " levels, " + std::to_string(cost.vertices) + " vertices, need about " +
                    std::to_string(cost.bytes >> 20) + " MiB, and the limit is " + std::to_string(limit >> 20) +
                    " MiB; ask for fewer levels",
                mesh.data().source);
}

}  // namespace tetrakis::detail
