#include "mesh_links.hpp"

#include "../base/ids.hpp"
#include "../base/parallel.hpp"

#include <oneapi/tbb/parallel_invoke.h>

#include <atomic>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_none = HalfedgeId::none;
// Half-edges above which two loops over them are worth a second thread.
constexpr std::uint32_t k_parallel_starts = 16384;

// Twins of the edges whose first use is in [begin, end). Whether all of them are manifold.
bool link_uses(const ControlMeshData& data, std::span<const EdgeUse> uses, std::uint32_t begin, std::uint32_t end,
               std::span<std::uint32_t> twin) {
    const auto count = static_cast<std::uint32_t>(uses.size());
    while (begin != 0 && begin < end && uses[begin].same_edge(uses[begin - 1])) ++begin;
    bool manifold = true;
    for (std::uint32_t i = begin, next; i < end; i = next) {
        const EdgeUse& use = uses[i];
        next = i + 1;
        while (next < count && use.same_edge(uses[next])) ++next;
        if (next == i + 2) {
            const std::uint32_t other = uses[i + 1].halfedge;
            twin[use.halfedge] = other;
            twin[other] = use.halfedge;
            manifold &= data.face_vertices[use.halfedge] != data.face_vertices[other];
        } else {
            for (std::uint32_t j = i; j != next; ++j) twin[uses[j].halfedge] = k_none;
            manifold &= next == i + 1;
        }
    }
    return manifold;
}

}  // namespace

MeshLinks link_mesh(const ControlMeshData& data, std::span<const EdgeUse> sorted_uses) {
    const auto face_count = static_cast<std::uint32_t>(data.face_offsets.size() - 1);
    const auto use_count = static_cast<std::uint32_t>(sorted_uses.size());
    MeshLinks links;
    links.face.resize(use_count);
    links.twin.resize(use_count);
    for_each_index(face_count, [&](std::uint32_t f) {
        for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h) links.face[h] = f;
    });
    std::atomic<bool> manifold = true;
    for_each_block(use_count, k_default_grain, [&](std::uint32_t begin, std::uint32_t end) {
        if (!link_uses(data, sorted_uses, begin, end, links.twin)) manifold.store(false, std::memory_order_relaxed);
    });
    links.manifold_edges = manifold.load(std::memory_order_relaxed);
    links.vertex_halfedge.assign(data.positions.size(), k_none);
    links.vertex_face_count.assign(data.positions.size(), 0);
    const auto count_faces = [&] {
        for (std::uint32_t v : data.face_vertices) ++links.vertex_face_count[v];
    };
    const auto find_starts = [&] {
        for (std::uint32_t h = 0; h < use_count; ++h) {
            std::uint32_t& start = links.vertex_halfedge[data.face_vertices[h]];
            start = start == k_none || links.twin[h] == k_none ? h : start;
        }
    };
    if (use_count > k_parallel_starts) {
        oneapi::tbb::parallel_invoke(count_faces, find_starts);
    } else {
        count_faces();
        find_starts();
    }
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
