#include "tetrakis/hier/mesh_links.hpp"

#include "tetrakis/hier/ids.hpp"
#include "tetrakis/hier/parallel.hpp"

#include <oneapi/tbb/parallel_invoke.h>

namespace tetrakis::detail {

namespace {
constexpr std::uint32_t k_none = HalfedgeId::none;
}

MeshLinks link_mesh(const ControlMeshData& data, std::span<const EdgeUse> sorted_uses) {
    const auto face_count = static_cast<std::uint32_t>(data.face_offsets.size() - 1);
    const auto use_count = static_cast<std::uint32_t>(sorted_uses.size());
    MeshLinks links;
    links.face.resize(use_count);
    links.twin.resize(use_count);
    for_each_index(face_count, [&](std::uint32_t f) {
        for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h) links.face[h] = f;
    });
    for_each_index(use_count, [&](std::uint32_t i) {
        const EdgeUse& use = sorted_uses[i];
        const auto same = [&](std::uint32_t j) { return j < use_count && use.same_edge(sorted_uses[j]); };
        // Below zero the index wraps to a value that same() refuses.
        const bool before = same(i - 1), after = same(i + 1);
        std::uint32_t twin = k_none;
        if (after && !before && !same(i + 2)) twin = sorted_uses[i + 1].halfedge;
        if (before && !after && !same(i - 2)) twin = sorted_uses[i - 1].halfedge;
        links.twin[use.halfedge] = twin;
    });
    links.vertex_halfedge.assign(data.positions.size(), k_none);
    links.vertex_face_count.assign(data.positions.size(), 0);
    oneapi::tbb::parallel_invoke(
        [&] {
            for (std::uint32_t v : data.face_vertices) ++links.vertex_face_count[v];
        },
        [&] {
            for (std::uint32_t h = 0; h < use_count; ++h) {
                std::uint32_t& start = links.vertex_halfedge[data.face_vertices[h]];
                if (start == k_none || links.twin[h] == k_none) start = h;
            }
        });
    return links;
}

std::uint32_t fan_size(const ControlMeshData& data, const MeshLinks& links, std::uint32_t vertex) {
    const std::uint32_t start = links.vertex_halfedge[vertex];
    if (start == k_none) return 0;
    std::uint32_t size = 0, h = start;
    do {
        ++size;
        const std::uint32_t f = links.face[h];
        h = links.twin[h == data.face_offsets[f] ? data.face_offsets[f + 1] - 1 : h - 1];
    } while (h != start && h != k_none);
    return size;
}

}  // namespace tetrakis::detail
