#include "../../hier/obj/obj_text.hpp"
#include "mesh_codecs.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <vector>

namespace tetrakis::detail {

TriangleMesh decode_obj(std::string_view text, const std::filesystem::path& path, const RunContext& context) {
    ControlMeshData data = read_obj_text(text, path.string(), ObjUse::triangles, context);
    const auto reject = [&](std::size_t f, const std::string& message) {
        throw Error(ErrorCode::invalid_input, message, path, data.face_lines[f]);
    };
    const auto check = [&](std::size_t f, std::uint32_t i, std::size_t count, const char* what) {
        if (i >= count)
            reject(f, i < k_obj_no_such
                          ? fmt::format("this face uses {} {}, but the file has {}; the file may be cut short", what,
                                        i + 1, count)
                          : fmt::format("this face uses a {} that no number can name: it counts back before the first "
                                        "one, or has too many digits",
                                        what));
    };
    for (std::size_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
        const std::uint32_t first = data.face_offsets[f], size = data.face_offsets[f + 1] - first;
        if (size < 3)
            reject(f, fmt::format("this face has {} corners; complete it to three or more, or remove it", size));
        for (std::uint32_t h = first; h < first + size; ++h) {
            check(f, data.face_vertices[h], data.positions.size(), "vertex");
            if (!data.face_uvs.empty() && data.face_uvs[h] != k_obj_absent)
                check(f, data.face_uvs[h], data.uvs.size(), "texture coordinate");
            if (!data.face_normals.empty() && data.face_normals[h] != k_obj_absent)
                check(f, data.face_normals[h], data.normals.size(), "normal");
        }
    }
    for (auto* const names : {&data.materials, &data.groups})
        std::ranges::replace(*names, std::string(), std::string("default"));
    const auto drop_unless_whole = [](std::vector<std::uint32_t>& layer, auto& values) {
        if (!layer.empty() && std::ranges::find(layer, k_obj_absent) == layer.end()) return;
        layer.clear();
        values.clear();
    };
    drop_unless_whole(data.face_uvs, data.uvs);
    drop_unless_whole(data.face_normals, data.normals);
    TriangleMesh mesh = cut_faces(std::move(data));
    // If all corners use the normal with their vertex's index (files of tetrakis without creases), they are by vertex.
    if (mesh.triangle_normals == mesh.triangles && mesh.normals.size() == mesh.positions.size())
        mesh.triangle_normals.clear();
    return mesh;
}

std::string printable_name(std::string_view name) {
    std::string result(name.empty() ? "unnamed" : name);
    for (char& c : result)
        if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '_';
    if (result.back() == '\\') result.back() = '_';  // as the last character it continues the line
    return result;
}

namespace {

void append_face(std::string& out, const MeshView& mesh, std::uint64_t f) {
    const auto end = std::back_inserter(out);
    out += 'f';
    for (std::uint64_t c = mesh.face_begin(f); c < mesh.face_end(f); ++c) {
        fmt::format_to(end, FMT_COMPILE(" {}"), std::uint64_t{mesh.corners[c]} + 1);
        if (mesh.has_uvs()) fmt::format_to(end, FMT_COMPILE("/{}"), std::uint64_t{mesh.corner_uvs[c]} + 1);
        if (!mesh.has_normals()) continue;
        fmt::format_to(end, FMT_COMPILE("{}/{}"), mesh.has_uvs() ? "" : "/", std::uint64_t{mesh.normal(c)} + 1);
    }
    out += '\n';
}

}  // namespace

void encode_obj(const MeshView& mesh, AtomicFile& file, const RunContext& context) {
    file.write("# tetrakis\n");
    write_in_pieces(file, mesh.positions.size(), context, 0.0, 0.35, [&](std::string& out, std::uint64_t v) {
        const Vec3d& p = mesh.positions[v];
        fmt::format_to(std::back_inserter(out), FMT_COMPILE("v {} {} {}\n"), p.x, p.y, p.z);
    });
    write_in_pieces(file, mesh.has_uvs() ? mesh.uvs.size() : 0, context, 0.35, 0.5,
                    [&](std::string& out, std::uint64_t i) {
                        const Vec2d& uv = mesh.uvs[i];
                        fmt::format_to(std::back_inserter(out), FMT_COMPILE("vt {} {}\n"), uv.x, uv.y);
                    });
    write_in_pieces(file, mesh.normals.size(), context, 0.5, 0.75, [&](std::string& out, std::uint64_t v) {
        const Vec3d& n = mesh.normals[v];
        fmt::format_to(std::back_inserter(out), FMT_COMPILE("vn {} {} {}\n"), n.x, n.y, n.z);
    });
    std::vector<std::string> materials, groups;
    for (const std::string& name : mesh.materials) materials.push_back("usemtl " + printable_name(name) + "\n");
    for (const std::string& name : mesh.groups) groups.push_back("g " + printable_name(name) + "\n");
    write_in_pieces(file, mesh.face_count(), context, 0.75, 1.0, [&](std::string& out, std::uint64_t f) {
        const auto changes = [&](std::span<const std::uint32_t> numbers) {
            return !numbers.empty() && (f == 0 || numbers[f] != numbers[f - 1]);
        };
        if (changes(mesh.face_group)) out += groups[mesh.face_group[f]];
        if (changes(mesh.face_material)) out += materials[mesh.face_material[f]];
        append_face(out, mesh, f);
    });
}

}  // namespace tetrakis::detail
