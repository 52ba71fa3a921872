#include "mesh_encoders.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>

#include <iterator>

namespace tetrakis::detail {

std::string printable_name(std::string_view name) {
    std::string result(name.empty() ? "unnamed" : name);
    for (char& c : result)
        if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '_';
    return result;
}

namespace {

void append_face(std::string& out, const MeshView& mesh, std::uint64_t f) {
    const auto end = std::back_inserter(out);
    out += 'f';
    for (std::uint64_t c = mesh.face_begin(f); c < mesh.face_end(f); ++c) {
        const std::uint64_t v = std::uint64_t{mesh.corners[c]} + 1;
        if (mesh.has_uvs() && mesh.has_normals())
            fmt::format_to(end, FMT_COMPILE(" {}/{}/{}"), v, std::uint64_t{mesh.corner_uvs[c]} + 1,
                           std::uint64_t{mesh.normal(c)} + 1);
        else if (mesh.has_uvs())
            fmt::format_to(end, FMT_COMPILE(" {}/{}"), v, std::uint64_t{mesh.corner_uvs[c]} + 1);
        else if (mesh.has_normals())
            fmt::format_to(end, FMT_COMPILE(" {}//{}"), v, std::uint64_t{mesh.normal(c)} + 1);
        else
            fmt::format_to(end, FMT_COMPILE(" {}"), v);
    }
    out += '\n';
}

}  // namespace

void encode_obj(const MeshView& mesh, AtomicFile& file, const RunContext& context) {
    file.write("# tetrakis\n");
    write_in_pieces(file, mesh.positions.size(), context, 0.0, 0.35,
                    [&](std::string& out, std::uint64_t first, std::uint64_t last) {
                        for (std::uint64_t v = first; v < last; ++v) {
                            const Vec3d& p = mesh.positions[v];
                            fmt::format_to(std::back_inserter(out), FMT_COMPILE("v {} {} {}\n"), p.x, p.y, p.z);
                        }
                    });
    write_in_pieces(file, mesh.has_uvs() ? mesh.uvs.size() : 0, context, 0.35, 0.5,
                    [&](std::string& out, std::uint64_t first, std::uint64_t last) {
                        for (std::uint64_t i = first; i < last; ++i)
                            fmt::format_to(std::back_inserter(out), FMT_COMPILE("vt {} {}\n"), mesh.uvs[i].x,
                                           mesh.uvs[i].y);
                    });
    write_in_pieces(file, mesh.normals.size(), context, 0.5, 0.75,
                    [&](std::string& out, std::uint64_t first, std::uint64_t last) {
                        for (std::uint64_t v = first; v < last; ++v) {
                            const Vec3d& n = mesh.normals[v];
                            fmt::format_to(std::back_inserter(out), FMT_COMPILE("vn {} {} {}\n"), n.x, n.y, n.z);
                        }
                    });
    std::vector<std::string> materials, groups;
    for (const std::string& name : mesh.materials) materials.push_back("usemtl " + printable_name(name) + "\n");
    for (const std::string& name : mesh.groups) groups.push_back("g " + printable_name(name) + "\n");
    write_in_pieces(file, mesh.face_count(), context, 0.75, 1.0,
                    [&](std::string& out, std::uint64_t first, std::uint64_t last) {
                        for (std::uint64_t f = first; f < last; ++f) {
                            const auto changes = [&](std::span<const std::uint32_t> numbers) {
                                return !numbers.empty() && (f == 0 || numbers[f] != numbers[f - 1]);
                            };
                            if (changes(mesh.face_group)) out += groups[mesh.face_group[f]];
                            if (changes(mesh.face_material)) out += materials[mesh.face_material[f]];
                            append_face(out, mesh, f);
                        }
                    });
}

}  // namespace tetrakis::detail
