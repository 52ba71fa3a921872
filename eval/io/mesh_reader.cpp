#include "mesh_reader.hpp"

#include "../../hier/base/files.hpp"
#include "../../hier/mesh/face_cutter.hpp"
#include "mesh_codecs.hpp"

namespace tetrakis {

namespace detail {

TriangleMesh cut_faces(PolygonMesh&& faces, std::span<const std::uint32_t> corner_normals) {
    TriangleMesh mesh;
    FaceCutter cutter;
    std::vector<Vec3d> points;
    for (std::uint32_t f = 0; f < faces.face_count(); ++f) {
        const std::uint32_t begin = faces.face_offsets[f];
        points.clear();
        for (std::uint32_t c = begin; c < faces.face_offsets[f + 1]; ++c)
            points.push_back(faces.positions[faces.face_vertices[c]]);
        const auto add = [&](std::uint32_t a, std::uint32_t tip, std::uint32_t b) {
            const auto add_corners = [&](const auto& of_corner, auto& triangles) {
                if (!of_corner.empty())
                    triangles.push_back({of_corner[begin + a], of_corner[begin + tip], of_corner[begin + b]});
            };
            add_corners(faces.face_vertices, mesh.triangles);
            add_corners(faces.face_uvs, mesh.triangle_uvs);
            add_corners(corner_normals, mesh.triangle_normals);
            if (!faces.face_material.empty()) mesh.triangle_material.push_back(faces.face_material[f]);
            if (!faces.face_group.empty()) mesh.triangle_group.push_back(faces.face_group[f]);
        };
        cutter.cut(
            points, [](std::uint32_t, std::uint32_t) { return true; }, add);
    }
    mesh.positions = std::move(faces.positions);
    mesh.normals = std::move(faces.normals);
    mesh.uvs = std::move(faces.uvs);
    mesh.materials = std::move(faces.materials);
    mesh.groups = std::move(faces.groups);
    return mesh;
}

}  // namespace detail

TriangleMesh read_triangle_mesh(const std::filesystem::path& path, const RunContext& context) {
    const std::string extension = detail::lower_extension(path);
    const bool obj = extension == ".obj", ply = extension == ".ply", gltf = extension == ".glb" || extension == ".gltf";
    if (!obj && !ply && !gltf)
        throw Error(ErrorCode::unsupported, "meshes are read from .obj, .ply, .glb and .gltf files", path);
    const std::string bytes = detail::read_file(path, context);
    if (bytes.empty()) throw Error(ErrorCode::invalid_input, "the file is empty", path);
    TriangleMesh mesh = obj   ? detail::decode_obj(bytes, path, context)
                        : ply ? detail::decode_ply(bytes, path, context)
                              : detail::decode_gltf(bytes, path);
    if (mesh.triangles.empty()) throw Error(ErrorCode::invalid_input, "the file has no faces", path);
    return mesh;
}

}  // namespace tetrakis
