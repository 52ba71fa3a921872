#include "tetrakis/eval/io/split_vertices.hpp"

#include "tetrakis/hier/error.hpp"

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

}  // namespace tetrakis::detail
