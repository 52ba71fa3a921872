#include "tetrakis/refine/adaptive_sqrt3.hpp"

#include "tetrakis/refine/sqrt3_points.hpp"

#include <unordered_map>
#include <utility>

namespace tetrakis {

Sqrt3Mesh sqrt3_mesh(const Sqrt3Forest& forest, const Sqrt3MeshOptions& options) {
    Sqrt3Mesh out;
    out.leaves = forest.leaves();
    const ControlMeshData& data = forest.mesh().data();
    std::unordered_map<Sqrt3Vertex, std::uint32_t> number;
    std::vector<std::uint64_t> leaving;
    out.mesh.face_offsets.push_back(0);
    for (const Sqrt3Leaf& leaf : out.leaves) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [at, fresh] =
                number.try_emplace(leaf.vertex[k], static_cast<std::uint32_t>(out.vertices.size()));
            if (fresh) {
                out.vertices.push_back(leaf.vertex[k]);
                out.levels.push_back(-1);
                leaving.push_back(0);
            }
            const std::uint32_t v = at->second;
            out.mesh.face_vertices.push_back(v);
            if (leaf.vertex_level[k] <= out.levels[v]) continue;
            out.levels[v] = leaf.vertex_level[k];
            leaving[v] = leaf.leaving[k];
        }
        out.mesh.face_offsets.push_back(static_cast<std::uint32_t>(out.mesh.face_vertices.size()));
        if (!data.face_material.empty()) out.mesh.face_material.push_back(data.face_material[leaf.control_face.value]);
        if (!data.face_group.empty()) out.mesh.face_group.push_back(data.face_group[leaf.control_face.value]);
    }
    out.mesh.materials = data.materials;
    out.mesh.groups = data.groups;
    Sqrt3Points points(forest.mesh());
    for (std::size_t v = 0; v < leaving.size(); ++v) {
        LimitPoint limit;
        if (options.limit || options.normals) limit = points.limit(out.levels[v], leaving[v]);
        out.mesh.positions.push_back(options.limit ? limit.position : points.position(out.levels[v], leaving[v]));
        if (options.normals) out.mesh.normals.push_back(limit.normal);
    }
    return out;
}

}  // namespace tetrakis
