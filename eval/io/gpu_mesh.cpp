#include "gpu_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "mesh_view.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace tetrakis {

namespace {

void check_float(std::initializer_list<double> numbers, const char* what, std::uint64_t vertex, const char* advice) {
    if (!std::all_of(numbers.begin(), numbers.end(), detail::fits_float))
        throw Error(ErrorCode::invalid_input,
                    fmt::format("the {} of vertex {} exceeds what floats hold; {}", what, vertex, advice));
}

}  // namespace

GpuMesh gpu_mesh(const TriangleMesh& mesh, const Vec3d& origin) {
    const detail::MeshView view(mesh);
    view.check();
    const detail::SplitVertices split(view, true);
    GpuMesh out;
    out.origin = origin;
    for (std::uint64_t v = 0; v < split.count; ++v) {
        out.vertices.push_back(split.original(v));
        const Vec3d local = mesh.positions[out.vertices.back()] - origin;
        check_float({local.x, local.y, local.z}, "position", out.vertices.back(),
                    "pass an origin near the model, or scale it");
        out.positions.emplace_back(local);
        if (view.has_normals()) out.normals.emplace_back(unit_or_zero(mesh.normals[split.normal(v)]));
        if (!view.has_uvs()) continue;
        const std::uint32_t uv = split.vertex_uv[v];
        const Vec2d at = uv == detail::SplitVertices::k_no_uv ? Vec2d(0) : mesh.uvs[uv];
        check_float({at.x, at.y}, "texture coordinate", out.vertices.back(), "scale it");
        out.uvs.emplace_back(at);
    }
    const auto corners = split.corner_vertex.empty() ? view.corners : std::span(split.corner_vertex);
    out.indices.assign(corners.begin(), corners.end());
    return out;
}

}  // namespace tetrakis
