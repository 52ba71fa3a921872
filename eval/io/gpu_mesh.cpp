#include "gpu_mesh.hpp"

#include "mesh_view.hpp"

namespace tetrakis {

GpuMesh gpu_mesh(const TriangleMesh& mesh, const Vec3d& origin) {
    const detail::MeshView view(mesh);
    view.check();
    const detail::SplitVertices split(view, true);
    GpuMesh out;
    out.origin = origin;
    for (std::uint64_t v = 0; v < split.count; ++v) {
        out.vertices.push_back(split.original(v));
        out.positions.emplace_back(mesh.positions[out.vertices.back()] - origin);
        if (view.has_normals()) out.normals.emplace_back(unit_or_zero(mesh.normals[split.normal(v)]));
        if (!view.has_uvs()) continue;
        const std::uint32_t uv = split.vertex_uv[v];
        out.uvs.emplace_back(uv == detail::SplitVertices::k_no_uv ? Vec2d(0) : mesh.uvs[uv]);
    }
    const auto corners = split.corner_vertex.empty() ? view.corners : std::span(split.corner_vertex);
    out.indices.assign(corners.begin(), corners.end());
    return out;
}

}  // namespace tetrakis
