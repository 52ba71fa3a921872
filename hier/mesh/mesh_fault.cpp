#include "mesh_check.hpp"

#include "../base/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

// What faults are called, and where they are.
namespace tetrakis {

namespace {

using Kind = MeshFaultKind;

// Faults quoted by an exception; a list of all comes from find_faults().
constexpr std::size_t k_quoted_faults = 5;

std::uint64_t line_at(const std::vector<std::uint64_t>& lines, std::uint32_t i) {
    return i < lines.size() ? lines[i] : 0;
}

std::string with_line(const std::string& text, std::uint64_t line) {
    return line == 0 ? text : fmt::format("{} (line {})", text, line);
}

std::uint64_t line_of(const ControlMeshData& data, Kind kind, std::uint32_t element) {
    switch (kind) {
        case Kind::array_size:
        case Kind::no_faces:
            return 0;
        case Kind::non_finite_uv:
            return line_at(data.uv_lines, element);
        case Kind::non_finite_vertex:
        case Kind::absurd_coordinate:
        case Kind::non_manifold_vertex:
            return line_at(data.vertex_lines, element);
        case Kind::crease_tag:
            return data.creases[element].line;
        case Kind::corner_tag:
            return data.corners[element].line;
        case Kind::corner_angle_tag:
            return data.corner_angles[element].line;
        case Kind::hole_tag:
            return line_at(data.hole_lines, element);
        default:
            return line_at(data.face_lines, element);
    }
}

}  // namespace

std::string_view name(MeshFaultKind kind) {
    constexpr std::string_view k_names[] = {"array size",
                                            "no faces",
                                            "non-finite vertex",
                                            "absurd coordinate",
                                            "face too small",
                                            "vertex out of range",
                                            "repeated vertex",
                                            "non-finite texture coordinate",
                                            "texture coordinate out of range",
                                            "normal out of range",
                                            "group out of range",
                                            "crease tag",
                                            "corner tag",
                                            "corner angle tag",
                                            "hole tag",
                                            "duplicate face",
                                            "non-manifold edge",
                                            "opposite orientation",
                                            "non-manifold vertex"};
    static_assert(std::size(k_names) == static_cast<std::size_t>(Kind::non_manifold_vertex) + 1);
    return k_names[static_cast<std::size_t>(kind)];
}

namespace detail {

std::string vertex_name(const ControlMeshData& data, std::uint32_t v) {
    if (v == VertexId::none)
        return "a vertex that no number can name (it counts back before the first one, or has too many digits)";
    return with_line(fmt::format("vertex {}", std::uint64_t{v} + data.first_number), line_at(data.vertex_lines, v));
}

std::string face_name(const ControlMeshData& data, std::uint32_t f) {
    return with_line(fmt::format("face {}", std::uint64_t{f} + data.first_number), line_at(data.face_lines, f));
}

MeshFault make_fault(const ControlMeshData& data, MeshFaultKind kind, std::uint32_t element, std::string message) {
    return {kind, element, line_of(data, kind, element), std::move(message)};
}

void throw_faults(const ControlMeshData& data, const std::vector<MeshFault>& faults) {
    if (faults.empty()) return;
    std::string text = faults.front().message;
    for (std::size_t i = 1; i < std::min(faults.size(), k_quoted_faults); ++i)
        text += faults[i].line != 0 ? fmt::format("\n  line {}: {}", faults[i].line, faults[i].message)
                                    : fmt::format("\n  {}", faults[i].message);
    if (faults.size() > 1)
        text += faults.size() > k_quoted_faults ? fmt::format("\n  ... {} faults in all", faults.size())
                                                : fmt::format("\n  {} faults in all", faults.size());
    throw Error(ErrorCode::invalid_input, text, data.source, faults.front().line);
}

}  // namespace detail
}  // namespace tetrakis
