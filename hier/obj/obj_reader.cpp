#include "obj_reader.hpp"

#include "../base/error.hpp"
#include "../base/files.hpp"
#include "../mesh/mesh_repair.hpp"
#include "obj_text.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace tetrakis {

namespace {

/// Texture coordinates and normals must exist for all corners or none: (0, 0) is filled in, normals are dropped.
void complete_layers(ControlMeshData& data) {
    const std::size_t corners = data.face_vertices.size();
    const auto is_absent = [](std::uint32_t i) { return i == detail::k_obj_absent; };
    if (data.face_uvs.empty()) {
        data.uvs.clear();
        data.uv_lines.clear();
    } else if (const auto bare = std::ranges::count_if(data.face_uvs, is_absent); bare != 0) {
        const auto origin = static_cast<std::uint32_t>(data.uvs.size());
        // Numbers above the file's are left for ControlMesh::build() to refuse: no value added here may match them.
        const bool all_there =
            std::ranges::all_of(data.face_uvs, [&](std::uint32_t i) { return is_absent(i) || i < origin; });
        std::ranges::replace_if(data.face_uvs, is_absent, all_there ? origin : 0);
        if (all_there) {
            data.uvs.emplace_back(0.0, 0.0);
            data.uv_lines.push_back(0);
            data.warnings.push_back(
                fmt::format("{} of {} face corners have no texture coordinate; they get (0, 0)", bare, corners));
        }
    }
    const auto bare = std::ranges::count_if(data.face_normals, is_absent);
    if (!data.face_normals.empty() && bare == 0) return;
    if (bare != 0)
        data.warnings.push_back(
            fmt::format("{} of {} face corners have no normal; all normals are left out", bare, corners));
    data.normals.clear();
    data.face_normals.clear();
}

/// Joins the first few sentences to one, with the number of the others.
std::string first_of(const std::vector<std::string>& sentences) {
    constexpr std::size_t k_most = 4;
    std::string text;
    for (std::size_t i = 0; i < std::min(k_most, sentences.size()); ++i) text += (i == 0 ? "" : "; ") + sentences[i];
    if (sentences.size() > k_most) text += fmt::format("; and {} more", sentences.size() - k_most);
    return text;
}

}  // namespace

ControlMeshData parse_obj(std::string_view text, std::string source, const ReadOptions& options,
                          const RunContext& context) {
    if (text.find_first_not_of(" \t\r\n") == std::string_view::npos)
        throw Error(ErrorCode::invalid_input, "the file is empty; give an OBJ file with vertices and faces",
                    std::move(source));
    ControlMeshData data = detail::read_obj_text(text, std::move(source), detail::ObjUse::control_mesh, context);
    complete_layers(data);
    if (options.weld)
        for (const std::string& report : weld(data, *options.weld)) data.warnings.push_back("welded: " + report);
    if (!options.repair) return data;
    const bool had_faces = data.face_offsets.size() > 1;
    const std::vector<std::string> reports = repair(data);
    if (had_faces && data.face_vertices.empty())
        throw Error(ErrorCode::invalid_input, "no face is left to work with; the repair " + first_of(reports),
                    data.source);
    for (const std::string& report : reports) data.warnings.push_back("repaired: " + report);
    return data;
}

ControlMeshData read_obj(const std::filesystem::path& path, const ReadOptions& options, const RunContext& context) {
    return parse_obj(detail::read_file(path, context), path.string(), options, context);
}

ControlMesh load_control_mesh(const std::filesystem::path& path, const ReadOptions& options,
                              const RunContext& context) {
    context.report("load", 0.0);
    ControlMeshData data = read_obj(path, options, context);
    context.report("load", 1.0);
    return ControlMesh::build(std::move(data), context);
}

}  // namespace tetrakis
