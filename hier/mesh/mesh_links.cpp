#include "mesh_links.hpp"

#include "../base/ids.hpp"
#include "../base/parallel.hpp"

#include <algorithm>
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
    for_each_index(vertex_count, [&](std::uint32_t v) { std::sort(uses.data() + begin[v], uses.data() + end[v]); });
    return uses;
}

const EdgeUse* find_edge(std::span<const EdgeUse> sorted_uses, std::uint32_t a, std::uint32_t b) {
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    const auto it = std::ranges::lower_bound(sorted_uses, EdgeUse{low, high, 0});
    return it != sorted_uses.end() && it->low == low && it->high == high ? &*it : nullptr;
}

MeshLinks link_mesh(const ControlMeshData& data, std::span<const EdgeUse> sorted_uses) {
    const auto face_count = static_cast<std::uint32_t>(data.face_offsets.size() - 1);
    const auto use_count = static_cast<std::uint32_t>(sorted_uses.size());
    MeshLinks links;
    links.face.resize(use_count);
    links.twin.assign(use_count, HalfedgeId::none);
    for_each_index(face_count, [&](std::uint32_t f) {
        for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h) links.face[h] = f;
    });
    for (std::uint32_t i = 0, next; i < use_count; i = next) {
        const EdgeUse& use = sorted_uses[i];
        for (next = i + 1; next < use_count && use.same_edge(sorted_uses[next]);) ++next;
        const std::uint32_t other = sorted_uses[next - 1].halfedge;
        if (next == i + 2) links.twin[use.halfedge] = other, links.twin[other] = use.halfedge;
        links.manifold_edges = links.manifold_edges && next <= i + 2 &&
                               (next == i + 1 || data.face_vertices[use.halfedge] != data.face_vertices[other]);
    }
    links.vertex_halfedge.assign(data.positions.size(), HalfedgeId::none);
    links.vertex_face_count.assign(data.positions.size(), 0);
    for (std::uint32_t h = 0; h < use_count; ++h) {
        const std::uint32_t v = data.face_vertices[h];
        ++links.vertex_face_count[v];
        std::uint32_t& start = links.vertex_halfedge[v];
        start = start == HalfedgeId::none || links.twin[h] == HalfedgeId::none ? h : start;
    }
    return links;
}

}  // namespace tetrakis::detail
