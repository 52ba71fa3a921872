#include "gpu_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "split_vertices.hpp"

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
    const MeshView view(mesh);
    view.check();
    const detail::SplitVertices split(view, true);
    GpuMesh out;
    out.origin = origin;
    for (const auto& [vertex, normal, uv] : split.vertices()) {
        out.vertices.push_back(vertex);
        const Vec3d local = mesh.positions[vertex] - origin;
        check_float({local.x, local.y, local.z}, "position", vertex, "pass an origin near the model, or scale it");
        out.positions.emplace_back(local);
        if (view.has_normals()) out.normals.emplace_back(unit_or_zero(mesh.normals[normal]));
        if (!view.has_uvs()) continue;
        const Vec2d at = uv == detail::SplitVertices::k_no_uv ? Vec2d(0) : mesh.uvs[uv];
        check_float({at.x, at.y}, "texture coordinate", vertex, "scale it");
        out.uvs.emplace_back(at);
    }
    out.indices.assign(split.corners().begin(), split.corners().end());
    return out;
}

}  // namespace tetrakis
