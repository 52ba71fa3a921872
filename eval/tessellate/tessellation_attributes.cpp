#include "tessellation_attributes.hpp"

#include "../../hier/base/parallel.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <tuple>

namespace tetrakis {

void geometric_normals(TriangleMesh& mesh) {
    mesh.normals.assign(mesh.positions.size(), Vec3d(0));
    for (const auto& t : mesh.triangles) {
        const Vec3d a = mesh.positions[t[0]];
        const Vec3d n = glm::cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
        for (std::uint32_t v : t) mesh.normals[v] += n;
    }
    for (Vec3d& n : mesh.normals) n = unit_or_zero(n);
}

void add_uvs(TriangleMesh& mesh, const std::function<Vec2d(std::uint32_t, std::size_t)>& corner_uv,
             const RunContext& context) {
    const std::uint32_t count = static_cast<std::uint32_t>(mesh.triangles.size());
    struct Corner {
        std::uint32_t vertex;
        Vec2d uv;
        std::uint32_t triangle;
        std::uint8_t k;
    };
    std::vector<Corner> corners(std::size_t{3} * count);
    for_each_reported(count, 128, context, "attributes", 0, 0.7, [&](std::uint32_t t) {
        for (std::uint8_t k = 0; k < 3; ++k)
            corners[std::size_t{3} * t + k] = {mesh.triangles[t][k], corner_uv(t, k), t, k};
    });
    oneapi::tbb::parallel_sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
        return std::tie(a.vertex, a.uv.x, a.uv.y, a.triangle, a.k) <
               std::tie(b.vertex, b.uv.x, b.uv.y, b.triangle, b.k);
    });
    mesh.uvs.clear();
    mesh.triangle_uvs.assign(count, {});
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Corner& c = corners[i];
        if (i == 0 || corners[i - 1].vertex != c.vertex || corners[i - 1].uv != c.uv) mesh.uvs.push_back(c.uv);
        mesh.triangle_uvs[c.triangle][c.k] = static_cast<std::uint32_t>(mesh.uvs.size() - 1);
    }
}

void add_face_attributes(const ControlMesh& control, std::span<const std::uint32_t> triangle_face, TriangleMesh& mesh) {
    const ControlMeshData& data = control.data();
    const auto carry = [&](const std::vector<std::uint32_t>& from, std::vector<std::uint32_t>& to) {
        if (from.empty()) return;
        to.resize(triangle_face.size());
        for (std::size_t t = 0; t < triangle_face.size(); ++t) to[t] = from[triangle_face[t]];
    };
    carry(data.face_material, mesh.triangle_material);
    carry(data.face_group, mesh.triangle_group);
    if (!data.face_material.empty()) mesh.materials = data.materials;
    if (!data.face_group.empty()) mesh.groups = data.groups;
}

}  // namespace tetrakis
