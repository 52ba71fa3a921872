#include "split_vertices.hpp"

#include "../../hier/base/error.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <cstring>
#include <numeric>

namespace tetrakis::detail {

SplitVertices::SplitVertices(const MeshView& mesh, bool uvs) : count(mesh.positions.size()) {
    constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
    const bool by_uv = uvs && mesh.has_uvs(), by_normal = !mesh.corner_normals.empty();
    if (!by_uv && !by_normal) return;
    const auto vertex_count = static_cast<std::uint32_t>(mesh.positions.size());
    if (by_normal) vertex_normal.assign(vertex_count, 0);
    if (by_uv) vertex_uv.assign(vertex_count, k_no_uv);
    corner_vertex.resize(mesh.corners.size());
    std::vector<std::uint8_t> met(vertex_count, 0);
    std::vector<std::uint32_t> next_copy(vertex_count, k_none);  // chains from a vertex through its copies
    for (std::size_t c = 0; c < mesh.corners.size(); ++c) {
        // Equal normals or coordinates under two numbers are one.
        const auto same = [&](std::uint32_t v) {
            return (!by_normal || vertex_normal[v] == mesh.corner_normals[c] ||
                    mesh.normals[vertex_normal[v]] == mesh.normals[mesh.corner_normals[c]]) &&
                   (!by_uv || vertex_uv[v] == mesh.corner_uvs[c] ||
                    mesh.uvs[vertex_uv[v]] == mesh.uvs[mesh.corner_uvs[c]]);
        };
        std::uint32_t v = mesh.corners[c];
        if (met[v] == 0) {
            met[v] = 1;
            if (by_normal) vertex_normal[v] = mesh.corner_normals[c];
            if (by_uv) vertex_uv[v] = mesh.corner_uvs[c];
        }
        while (!same(v)) {
            if (next_copy[v] == k_none) {
                if (count >= k_none - 1)
                    throw Error(ErrorCode::unsupported,
                                "too many vertices, split at seams and creases, for the format");
                next_copy[v] = static_cast<std::uint32_t>(count++);
                next_copy.push_back(k_none);
                if (by_normal) vertex_normal.push_back(mesh.corner_normals[c]);
                if (by_uv) vertex_uv.push_back(mesh.corner_uvs[c]);
                copy_of.push_back(mesh.corners[c]);
            }
            v = next_copy[v];
        }
        corner_vertex[c] = v;
    }
}

void join_split_vertices(TriangleMesh& mesh) {
    const auto count = static_cast<std::uint32_t>(mesh.positions.size());
    const auto compare = [&](const std::vector<Vec3d>& values, std::uint32_t a, std::uint32_t b) {
        return std::memcmp(&values[a], &values[b], sizeof(Vec3d));
    };
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    oneapi::tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const int by_bits = compare(mesh.positions, a, b);
        return by_bits != 0 ? by_bits < 0 : a < b;
    });
    std::vector<std::uint32_t> target(count);
    bool one_normal = true;
    for (std::uint32_t i = 0; i < count; ++i) {
        const bool fresh = i == 0 || compare(mesh.positions, order[i - 1], order[i]) != 0;
        target[order[i]] = fresh ? order[i] : target[order[i - 1]];
        if (!mesh.normals.empty() && compare(mesh.normals, target[order[i]], order[i]) != 0) one_normal = false;
    }
    if (!one_normal) mesh.triangle_normals = mesh.triangles;
    const bool reduce_normals = one_normal && !mesh.normals.empty();
    std::uint32_t kept = 0;
    for (std::uint32_t v = 0; v < count; ++v) {
        if (target[v] != v) {
            target[v] = target[target[v]];  // the first of its kind comes earlier and has its new number already
            continue;
        }
        mesh.positions[kept] = mesh.positions[v];
        if (reduce_normals) mesh.normals[kept] = mesh.normals[v];
        target[v] = kept++;
    }
    mesh.positions.resize(kept);
    if (reduce_normals) mesh.normals.resize(kept);
    for (auto& triangle : mesh.triangles)
        for (std::uint32_t& v : triangle) v = target[v];
}

}  // namespace tetrakis::detail
