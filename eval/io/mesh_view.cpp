#include "mesh_view.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/control_mesh.hpp"

#include <fmt/format.h>

#include <cmath>

namespace tetrakis {

namespace {

// An array of triples as an array of numbers.
std::span<const std::uint32_t> flat(const std::vector<std::array<std::uint32_t, 3>>& triples) {
    static_assert(sizeof(std::array<std::uint32_t, 3>) == 3 * sizeof(std::uint32_t));
    return triples.empty() ? std::span<const std::uint32_t>{} : std::span(triples.front().data(), 3 * triples.size());
}

[[noreturn]] void reject(const std::string& text) { throw Error(ErrorCode::invalid_input, "mesh to write: " + text); }

template <class V>
void check_finite(std::span<const V> values, const char* what) {
    for (std::size_t i = 0; i < values.size(); ++i)
        for (int axis = 0; axis < V::length(); ++axis)
            if (!std::isfinite(values[i][axis])) reject(fmt::format("{} {} is not finite", what, i));
}

void check_range(std::span<const std::uint32_t> indices, std::size_t count, const char* what) {
    for (std::size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= count)
            reject(fmt::format("{} number {} is {}, but there are {}", what, i, indices[i], count));
}

}  // namespace

MeshView::MeshView(const TriangleMesh& mesh)
    : positions(mesh.positions),
      normals(mesh.normals),
      uvs(mesh.uvs),
      corners(flat(mesh.triangles)),
      corner_uvs(flat(mesh.triangle_uvs)),
      corner_normals(flat(mesh.triangle_normals)),
      face_material(mesh.triangle_material),
      face_group(mesh.triangle_group),
      materials(mesh.materials),
      groups(mesh.groups) {}

template <class Polygons>
MeshView::MeshView(const Polygons& mesh, std::span<const std::uint32_t> normal_numbers)
    : positions(mesh.positions),
      normals(mesh.normals),
      uvs(mesh.uvs),
      corners(mesh.face_vertices),
      corner_uvs(mesh.face_uvs),
      corner_normals(normal_numbers),
      face_offsets(mesh.face_offsets),
      face_material(mesh.face_material),
      face_group(mesh.face_group),
      materials(mesh.materials),
      groups(mesh.groups) {}

MeshView::MeshView(const PolygonMesh& mesh) : MeshView(mesh, {}) {}
MeshView::MeshView(const ControlMeshData& mesh) : MeshView(mesh, mesh.face_normals) {}

void MeshView::check() const {
    if (!face_offsets.empty() && (face_offsets.front() != 0 || face_offsets.back() != corners.size()))
        reject("the face offsets do not span the face corners");
    for (std::size_t f = 0; f + 1 < face_offsets.size(); ++f)
        if (face_offsets[f + 1] < face_offsets[f] + std::uint64_t{3})
            reject(fmt::format("face {} has fewer than three corners", f));
    if (face_offsets.empty() && corners.size() % 3 != 0) reject("no face offsets, and corners that are not triangles");
    if (!corner_normals.empty() && corner_normals.size() != corners.size())
        reject(fmt::format("{} normal indices for {} face corners", corner_normals.size(), corners.size()));
    if (has_normals() && corner_normals.empty() && normals.size() != positions.size())
        reject(fmt::format("{} normals for {} vertices", normals.size(), positions.size()));
    if (has_uvs() && corner_uvs.size() != corners.size())
        reject(fmt::format("{} texture coordinate indices for {} face corners", corner_uvs.size(), corners.size()));
    const auto per_face = [&](std::span<const std::uint32_t> numbers, const char* what) {
        if (!numbers.empty() && numbers.size() != face_count())
            reject(fmt::format("{} {} numbers for {} faces", numbers.size(), what, face_count()));
    };
    per_face(face_material, "material");
    per_face(face_group, "group");
    check_range(corners, positions.size(), "vertex index");
    check_range(corner_uvs, uvs.size(), "texture coordinate index");
    check_range(corner_normals, normals.size(), "normal index");
    check_range(face_material, materials.size(), "face material");
    check_range(face_group, groups.size(), "face group");
    check_finite(positions, "position");
    check_finite(normals, "normal");
    check_finite(uvs, "texture coordinate");
}

}  // namespace tetrakis
