#include "mesh_links.hpp"

#include "../base/ids.hpp"
#include "../base/parallel.hpp"

#include <oneapi/tbb/parallel_invoke.h>

#include <algorithm>
#include <atomic>
#include <numeric>

namespace tetrakis::detail {

std::vector<EdgeUse> sorted_edge_uses(std::span<const std::uint32_t> face_offsets,
                                      std::span<const std::uint32_t> face_vertices, std::uint32_t vertex_count) {
    const auto visit = [&](auto&& visitor) {
        for (std::size_t f = 0; f + 1 < face_offsets.size(); ++f)
            for (std::uint32_t h = face_offsets[f], end = face_offsets[f + 1]; h < end; ++h) {
                const std::uint32_t a = face_vertices[h], b = face_vertices[h + 1 == end ? face_offsets[f] : h + 1];
                visitor(EdgeUse{std::min(a, b), std::max(a, b), h});
            }
    };
    std::vector<std::uint32_t> begin(std::size_t{vertex_count} + 1, 0);
    visit([&](const EdgeUse& use) { ++begin[use.low + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::uint32_t> end(begin.begin(), begin.end() - 1);
    std::vector<EdgeUse> uses(face_vertices.size());
    visit([&](const EdgeUse& use) { uses[end[use.low]++] = use; });
    for_each_index(vertex_count, [&](std::uint32_t v) {
        std::sort(uses.data() + begin[v], uses.data() + end[v], [](const EdgeUse& a, const EdgeUse& b) {
            return a.high != b.high ? a.high < b.high : a.halfedge < b.halfedge;
        });
    });
    return uses;
}

const EdgeUse* find_edge(std::span<const EdgeUse> sorted_uses, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    const auto it = std::lower_bound(sorted_uses.begin(), sorted_uses.end(), EdgeUse{low, high, 0},
                                     [](const EdgeUse& x, const EdgeUse& y) {
                                         if (x.low != y.low) return x.low < y.low;
                                         return x.high != y.high ? x.high < y.high : x.halfedge < y.halfedge;
                                     });
    return it != sorted_uses.end() && it->low == low && it->high == high ? &*it : nullptr;
}

namespace {

constexpr std::uint32_t k_no_face = HalfedgeId::none;
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
            for (std::uint32_t j = i; j != next; ++j) twin[uses[j].halfedge] = k_no_face;
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
    links.vertex_halfedge.assign(data.positions.size(), k_no_face);
    links.vertex_face_count.assign(data.positions.size(), 0);
    const auto count_faces = [&] {
        for (std::uint32_t v : data.face_vertices) ++links.vertex_face_count[v];
    };
    const auto find_starts = [&] {
        for (std::uint32_t h = 0; h < use_count; ++h) {
            std::uint32_t& start = links.vertex_halfedge[data.face_vertices[h]];
            start = start == k_no_face || links.twin[h] == k_no_face ? h : start;
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
    if (start == k_no_face) return 0;
    std::uint32_t size = 0, h = start;
    do {
        ++size;
        h = links.twin[prev_corner(data, links.face[h], h)];
    } while (h != start && h != k_no_face);
    return size;
}

}  // namespace tetrakis::detail
