#include "mesh_reader.hpp"

#include "../../hier/base/files.hpp"
#include "mesh_codecs.hpp"

namespace tetrakis {

namespace detail {

TriangleMesh cut_corners(const MeshView& faces) {
    TriangleMesh mesh;
    for_each_triangle(faces, [&](std::uint64_t f, const std::array<std::uint64_t, 3>& corners) {
        const auto add = [&](std::span<const std::uint32_t> of_corner, auto& triangles) {
            if (!of_corner.empty())
                triangles.push_back({of_corner[corners[0]], of_corner[corners[1]], of_corner[corners[2]]});
        };
        add(faces.corners, mesh.triangles);
        add(faces.corner_uvs, mesh.triangle_uvs);
        add(faces.corner_normals, mesh.triangle_normals);
        if (!faces.face_material.empty()) mesh.triangle_material.push_back(faces.face_material[f]);
        if (!faces.face_group.empty()) mesh.triangle_group.push_back(faces.face_group[f]);
    });
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
