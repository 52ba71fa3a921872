#include "mesh_reader.hpp"

#include "../../hier/base/files.hpp"
#include "../../hier/mesh/face_cutter.hpp"
#include "mesh_codecs.hpp"

namespace tetrakis {

namespace detail {

void cut_fans(std::span<const Fan> fans, std::span<const Vec3d> positions,
              std::initializer_list<std::vector<std::array<std::uint32_t, 3>>*> arrays) {
    FaceCutter cutter;
    std::vector<Vec3d> points;
    std::vector<std::array<std::uint32_t, 3>> cut, fan;
    for (const Fan& face : fans) {
        const auto corner = [](std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t i) {
            return i < 2 ? triangles[0][i] : triangles[i - 2][2];
        };
        const auto of_face = [&](auto& triangles) {
            return std::span(triangles).subspan(face.first, face.corners - 2);
        };
        points.clear();
        for (std::size_t i = 0; i < face.corners; ++i)
            points.push_back(positions[corner(of_face(**arrays.begin()), i)]);
        cut.clear();
        cutter.cut(
            points, [](std::uint32_t, std::uint32_t) { return true; },
            [&](std::uint32_t a, std::uint32_t tip, std::uint32_t b) {
                cut.push_back({a, tip, b});
            });
        for (auto* const array : arrays) {
            if (array->empty()) continue;
            const auto triangles = of_face(*array);
            fan.assign(triangles.begin(), triangles.end());
            for (std::size_t t = 0; t < cut.size(); ++t)
                for (std::size_t k = 0; k < 3; ++k) triangles[t][k] = corner(fan, cut[t][k]);
        }
    }
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
