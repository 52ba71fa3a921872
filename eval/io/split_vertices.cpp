#include "split_vertices.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/mesh_numbering.hpp"

#include <numeric>

namespace tetrakis::detail {

SplitVertices::SplitVertices(const MeshView& mesh, bool uvs) : mesh_corners_(mesh.corners) {
    const bool by_uv = uvs && mesh.has_uvs(), by_normal = !mesh.corner_normals.empty();
    vertices_.reserve(mesh.positions.size());
    for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) vertices_.push_back({v, by_normal ? 0 : v});
    if (!by_uv && !by_normal) return;
    // Linked lists from each vertex through its copies.
    constexpr std::uint32_t k_last = 0xFFFF'FFFFu, k_not_met = k_last - 1;
    std::vector<std::uint32_t> next_copy(vertices_.size(), k_not_met);
    own_corners_.reserve(mesh.corners.size());
    for (std::size_t c = 0; c < mesh.corners.size(); ++c) {
        const Vertex wanted{mesh.corners[c], mesh.normal(c), by_uv ? mesh.corner_uvs[c] : k_no_uv};
        // Normals and UVs are compared by value: equal ones may have different indices.
        const auto same = [&](const Vertex& v) {
            return (v.normal == wanted.normal || mesh.normals[v.normal] == mesh.normals[wanted.normal]) &&
                   (v.uv == wanted.uv || mesh.uvs[v.uv] == mesh.uvs[wanted.uv]);
        };
        std::uint32_t v = wanted.position;
        if (next_copy[v] == k_not_met) {
            next_copy[v] = k_last;
            vertices_[v] = wanted;
        }
        while (!same(vertices_[v])) {
            if (next_copy[v] == k_last) {
                if (vertices_.size() >= k_not_met)
                    throw Error(ErrorCode::unsupported,
                                "too many vertices, split at seams and creases, for the format");
                next_copy[v] = static_cast<std::uint32_t>(vertices_.size());
                next_copy.push_back(k_last);
                vertices_.push_back(wanted);
            }
            v = next_copy[v];
        }
        own_corners_.push_back(v);
    }
}

void join_split_vertices(TriangleMesh& mesh) {
    std::vector<std::uint32_t> all(mesh.positions.size());
    std::iota(all.begin(), all.end(), 0u);
    const std::vector<std::uint32_t> first = first_at_position(mesh.positions, std::move(all));
    bool one_normal = true;
    for (std::uint32_t v = 0; v < mesh.normals.size(); ++v)
        one_normal = one_normal && mesh.normals[first[v]] == mesh.normals[v];
    const Numbering joined(first);
    gather(mesh.positions, joined.kept);
    if (one_normal)
        gather(mesh.normals, joined.kept);
    else
        mesh.triangle_normals = mesh.triangles;
    for (auto& triangle : mesh.triangles)
        for (std::uint32_t& v : triangle) v = joined.number[v];
}

}  // namespace tetrakis::detail
