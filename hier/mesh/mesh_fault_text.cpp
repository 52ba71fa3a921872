#include "../base/ids.hpp"
#include "corner_tags.hpp"
#include "mesh_check.hpp"

#include <fmt/format.h>

#include <string_view>

namespace tetrakis {

namespace {

using Kind = MeshFaultKind;

// Faults quoted by an exception; a list of all comes from find_faults().
constexpr std::size_t k_quoted_faults = 5;

constexpr std::string_view k_repair_advice = "correct it in the modeller or use --repair";

std::uint64_t line_at(const std::vector<std::uint64_t>& lines, std::uint32_t i) {
    return i < lines.size() ? lines[i] : 0;
}

std::string with_line(const std::string& text, std::uint64_t line) {
    return line == 0 ? text : fmt::format("{} (line {})", text, line);
}

std::uint64_t line_of(const ControlMeshData& data, const detail::RawFault& fault) {
    const auto at = [&](const std::vector<std::uint64_t>& lines) { return line_at(lines, fault.element); };
    switch (fault.kind) {
        case Kind::array_size:
        case Kind::no_faces:
            return 0;
        case Kind::non_finite_uv:
            return at(data.uv_lines);
        case Kind::non_finite_vertex:
        case Kind::absurd_coordinate:
        case Kind::non_manifold_vertex:
            return at(data.vertex_lines);
        case Kind::crease_tag:
            return data.creases[fault.element].line;
        case Kind::corner_tag:
            return data.corners[fault.element].line;
        case Kind::corner_angle_tag:
            return data.corner_angles[fault.element].line;
        case Kind::hole_tag:
            return at(data.hole_lines);
        default:
            return at(data.face_lines);
    }
}

/// A number of a tag, where the file has one that a mesh can have.
std::string tag_number(std::uint32_t n) {
    return n == VertexId::none ? "a number below 0 or too large for any mesh" : std::to_string(n);
}

std::string tag_text(const ControlMeshData& data, const detail::RawFault& fault) {
    const std::string_view subject = fault.subject ? fault.subject : "";
    const std::uint64_t number = std::uint64_t{fault.element} + data.first_number;
    const std::string tag =
        fault.kind == Kind::crease_tag
            ? fmt::format("crease tag {} ({}, {})", number, tag_number(fault.a), tag_number(fault.b))
            : fmt::format("corner tag {} ({})", number, tag_number(fault.a));
    if (subject == "sharpness") {
        const float s = fault.kind == Kind::crease_tag ? data.creases[fault.element].sharpness
                                                       : data.corners[fault.element].sharpness;
        return fmt::format("{} has sharpness {}; it must be 0 or more, or use --repair to drop the tag", tag, s);
    }
    if (subject == "edge")
        return fmt::format(
            "{}: no face has an edge between {} and {}; tags count vertices from 0, or use --repair to drop the tag",
            tag, detail::vertex_name(data, fault.a), detail::vertex_name(data, fault.b));
    return fmt::format(
        "{} names a vertex that is not there, the last of {} is {}; tags count vertices from 0, or use "
        "--repair to drop the tag",
        tag, data.positions.size(), static_cast<std::int64_t>(data.positions.size()) - 1);
}

std::string angle_text(const ControlMeshData& data, const detail::RawFault& fault) {
    const std::string_view subject = fault.subject ? fault.subject : "";
    const auto& at = data.corner_angles[fault.element];
    const auto number = [&](std::uint32_t i) { return std::uint64_t{i} + data.first_number; };
    const std::string tag = fmt::format("corner angle tag {} (vertex {}, face {})", number(fault.element),
                                        tag_number(at.vertex), tag_number(at.face));
    constexpr std::string_view k_drop = "or use --repair to drop the tag";
    const std::size_t faces = data.face_offsets.size() - 1;
    if (subject == "vertex")
        return fmt::format("{} names a vertex that is not there, the last of {} is {}; tags count vertices from 0, {}",
                           tag, data.positions.size(), static_cast<std::int64_t>(data.positions.size()) - 1, k_drop);
    if (subject == "face")
        return fmt::format("{} names a face that is not there, the last of {} is {}; tags count faces from 0, {}", tag,
                           faces, static_cast<std::int64_t>(faces) - 1, k_drop);
    if (subject == "angle")
        return fmt::format("{} has {} degrees; they must be above 0 and below 360, and not 180, {}", tag,
                           detail::degrees(at.angle), k_drop);
    if (subject == "corner")
        return fmt::format("{}: {} does not touch {}; tags count vertices and faces from 0, {}", tag,
                           detail::face_name(data, at.face), detail::vertex_name(data, at.vertex), k_drop);
    const auto& before = data.corner_angles[fault.a];
    return fmt::format(
        "{} has {} degrees, but tag {} has {} for the same sector (the faces between two sharp edges); leave one, {}",
        tag, detail::degrees(at.angle), with_line(std::to_string(number(fault.a)), before.line),
        detail::degrees(before.angle), k_drop);
}

}  // namespace

std::string_view name(MeshFaultKind kind) {
    switch (kind) {
        case Kind::array_size:
            return "array size";
        case Kind::no_faces:
            return "no faces";
        case Kind::non_finite_vertex:
            return "non-finite vertex";
        case Kind::absurd_coordinate:
            return "absurd coordinate";
        case Kind::face_too_small:
            return "face too small";
        case Kind::vertex_out_of_range:
            return "vertex out of range";
        case Kind::repeated_vertex:
            return "repeated vertex";
        case Kind::non_finite_uv:
            return "non-finite texture coordinate";
        case Kind::uv_out_of_range:
            return "texture coordinate out of range";
        case Kind::normal_out_of_range:
            return "normal out of range";
        case Kind::group_out_of_range:
            return "group out of range";
        case Kind::crease_tag:
            return "crease tag";
        case Kind::corner_tag:
            return "corner tag";
        case Kind::corner_angle_tag:
            return "corner angle tag";
        case Kind::hole_tag:
            return "hole tag";
        case Kind::duplicate_face:
            return "duplicate face";
        case Kind::non_manifold_edge:
            return "non-manifold edge";
        case Kind::opposite_orientation:
            return "opposite orientation";
        case Kind::non_manifold_vertex:
            return "non-manifold vertex";
    }
    return "fault";
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

MeshFault describe(const ControlMeshData& data, const RawFault& fault) {
    // The element's own line goes with the fault; others are named with theirs.
    const std::uint64_t first = data.first_number, e = fault.element + first;
    const auto vertex = [&](std::uint32_t v) { return vertex_name(data, v); };
    const auto face = [&](std::uint32_t f) { return face_name(data, f); };
    const auto text = [&]() -> std::string {
        switch (fault.kind) {
            case Kind::array_size:
                return fmt::format("the arrays do not fit together: {}", fault.subject);
            case Kind::no_faces:
                return "there are no faces; a control mesh needs at least one";
            case Kind::non_finite_vertex:
                return fmt::format(
                    "vertex {} has a coordinate that is not a finite number; correct it, or use "
                    "--repair to drop its faces",
                    e);
            case Kind::absurd_coordinate:
                return fmt::format(
                    "vertex {} has a coordinate beyond {:.0e}; correct it, or use --repair to drop its "
                    "faces",
                    e, k_max_coordinate);
            case Kind::face_too_small:
                return fmt::format("face {} has {} corners; it needs 3 or more, or use --repair to drop it", e,
                                   fault.a);
            case Kind::vertex_out_of_range:
                return fmt::format(
                    "face {} uses {}, but there are {} vertices (numbers start at {}); check the export or use "
                    "--repair to "
                    "drop the face",
                    e, vertex(fault.a), data.positions.size(), first);
            case Kind::repeated_vertex:
                return fmt::format("face {} has {} twice; {}", e, vertex(fault.a), k_repair_advice);
            case Kind::non_finite_uv:
                return fmt::format(
                    "texture coordinate {} is not finite or beyond {:g}; correct it, or use --repair to put (0, 0)", e,
                    k_max_uv);
            case Kind::uv_out_of_range:
                return fmt::format(
                    "face {} uses texture coordinate {}, but there are {} (numbers start at {}); check the export or "
                    "use "
                    "--repair to put (0, 0)",
                    e, fault.a + first, data.uvs.size(), first);
            case Kind::normal_out_of_range:
                return fmt::format(
                    "face {} uses normal {}, but there are {} (numbers start at {}); check the export or use --repair "
                    "to "
                    "drop the normals",
                    e, fault.a + first, data.normals.size(), first);
            case Kind::group_out_of_range:
                return fmt::format(
                    "face {} has {} {}, which has no name in the list; check the export or use "
                    "--repair to drop these numbers",
                    e, fault.subject, fault.a);
            case Kind::crease_tag:
            case Kind::corner_tag:
                return tag_text(data, fault);
            case Kind::corner_angle_tag:
                return angle_text(data, fault);
            case Kind::hole_tag:
                return fmt::format(
                    "hole tag {} names face {}, but there are {} faces; tags count faces from 0, or use "
                    "--repair to drop the tag",
                    e, tag_number(fault.a), data.face_offsets.size() - 1);
            case Kind::duplicate_face:
                return fmt::format("face {} has the same vertices as {}; delete one, or use --repair", e,
                                   face(fault.a));
            case Kind::non_manifold_edge:
                return fmt::format(
                    "the edge between {} and {} of face {} has more than two faces; {} to split it into boundaries",
                    vertex(fault.a), vertex(fault.b), e, k_repair_advice);
            case Kind::opposite_orientation:
                return fmt::format(
                    "the two faces at the edge between {} and {} (one is face {}) run along it in the same direction; "
                    "flip one, or use --repair to orient all faces alike",
                    vertex(fault.a), vertex(fault.b), e);
            case Kind::non_manifold_vertex:
                return fmt::format(
                    "the {} faces at vertex {} are not one fan, they only touch there (one is {}); {} to split it",
                    fault.b, e, face(fault.a), k_repair_advice);
        }
        return std::string(name(fault.kind));
    };
    return {fault.kind, fault.element, line_of(data, fault), text()};
}

void throw_faults(const ControlMeshData& data, const std::vector<RawFault>& faults) {
    if (faults.empty()) return;
    const MeshFault first = describe(data, faults.front());
    std::string text = first.message;
    for (std::size_t i = 1; i < std::min(faults.size(), k_quoted_faults); ++i) {
        const MeshFault fault = describe(data, faults[i]);
        text += fault.line != 0 ? fmt::format("\n  line {}: {}", fault.line, fault.message)
                                : fmt::format("\n  {}", fault.message);
    }
    if (faults.size() > 1)
        text += faults.size() > k_quoted_faults ? fmt::format("\n  ... {} faults in all", faults.size())
                                                : fmt::format("\n  {} faults in all", faults.size());
    throw Error(ErrorCode::invalid_input, text, data.source, first.line);
}

}  // namespace detail
}  // namespace tetrakis
