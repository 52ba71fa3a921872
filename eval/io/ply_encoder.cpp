#include "mesh_encoders.hpp"
#include "split_vertices.hpp"

#include <fmt/format.h>

namespace tetrakis::detail {

void encode_ply(const MeshView& mesh, AtomicFile& file, const RunContext& context) {
    const SplitVertices split(mesh, false);
    std::uint64_t largest_face = 3;
    for (std::uint64_t f = 0; f + 1 < mesh.face_offsets.size(); ++f)
        largest_face = std::max(largest_face, mesh.face_end(f) - mesh.face_begin(f));
    // Texture coordinates are a list of two numbers a corner; most readers expect counts in one byte.
    const bool short_lists = 2 * largest_face <= 255;
    const char* count_type = short_lists ? "uchar" : "uint";
    // Readers expect signed indices; unsigned ones only where they must be.
    const char* index_type = split.count <= 0x7FFF'FFFFu ? "int" : "uint";

    std::string header = "ply\nformat binary_little_endian 1.0\ncomment tetrakis\n";
    for (std::size_t i = 0; i < mesh.materials.size(); ++i)
        header += fmt::format("comment material {} {}\n", i, printable_name(mesh.materials[i]));
    for (std::size_t i = 0; i < mesh.groups.size(); ++i)
        header += fmt::format("comment group {} {}\n", i, printable_name(mesh.groups[i]));
    header += fmt::format("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n", split.count);
    if (mesh.has_normals()) header += "property double nx\nproperty double ny\nproperty double nz\n";
    header +=
        fmt::format("element face {}\nproperty list {} {} vertex_indices\n", mesh.face_count(), count_type, index_type);
    if (mesh.has_uvs()) header += fmt::format("property list {} double texcoord\n", count_type);
    if (!mesh.face_material.empty()) header += "property int material_index\n";
    if (!mesh.face_group.empty()) header += "property int group_index\n";
    file.write(header + "end_header\n");

    write_in_pieces(file, split.count, context, 0.0, 0.5,
                    [&](std::string& out, std::uint64_t first, std::uint64_t last) {
                        for (std::uint64_t v = first; v < last; ++v) {
                            append_bytes(out, mesh.positions[split.original(v)]);
                            if (mesh.has_normals()) append_bytes(out, mesh.normals[split.normal(v)]);
                        }
                    });
    const auto append_count = [&](std::string& out, std::uint64_t count) {
        if (short_lists)
            append_bytes(out, static_cast<std::uint8_t>(count));
        else
            append_bytes(out, static_cast<std::uint32_t>(count));
    };
    write_in_pieces(
        file, mesh.face_count(), context, 0.5, 1.0, [&](std::string& out, std::uint64_t first, std::uint64_t last) {
            for (std::uint64_t f = first; f < last; ++f) {
                const std::uint64_t begin = mesh.face_begin(f), end = mesh.face_end(f);
                append_count(out, end - begin);
                for (std::uint64_t c = begin; c < end; ++c)
                    append_bytes(out, split.corner_vertex.empty() ? mesh.corners[c] : split.corner_vertex[c]);
                if (mesh.has_uvs()) {
                    append_count(out, 2 * (end - begin));
                    for (std::uint64_t c = begin; c < end; ++c) append_bytes(out, mesh.uvs[mesh.corner_uvs[c]]);
                }
                if (!mesh.face_material.empty()) append_bytes(out, mesh.face_material[f]);
                if (!mesh.face_group.empty()) append_bytes(out, mesh.face_group[f]);
            }
        });
}

}  // namespace tetrakis::detail
