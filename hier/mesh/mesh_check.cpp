#include "mesh_check.hpp"

#include "../base/error.hpp"
#include "../base/ids.hpp"
#include "corner_tags.hpp"
#include "mesh_links.hpp"
#include "mesh_numbering.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace tetrakis {

namespace detail {
namespace {

using Kind = MeshFaultKind;

// Number of faults that an exception quotes; find_faults() lists all.
constexpr std::size_t k_quoted_faults = 5;

std::uint64_t line_at(const std::vector<std::uint64_t>& lines, std::uint32_t i) {
    return i < lines.size() ? lines[i] : 0;
}

std::string with_line(const std::string& text, std::uint64_t line) {
    return line == 0 ? text : fmt::format("{} (line {})", text, line);
}

constexpr std::string_view k_repair_advice = "correct it in the modeller or use --repair";
// Largest number of corners for which comparing all pairs is faster than sorting.
constexpr std::uint32_t k_small_face = 16;

// If twice the area over the squared perimeter is below this, a face is a line within the precision of doubles.
constexpr double k_zero_area = 1e-14;

void check_sizes(const ControlMeshData& data, std::vector<MeshFault>& faults) {
    const auto complain = [&](const char* what) {
        faults.push_back({Kind::array_size, 0, 0, fmt::format("the arrays do not fit together: {}", what)});
    };
    // Four numbers are reserved: "none", and room for indices two elements ahead.
    constexpr std::size_t k_limit = 0xFFFF'FFFBu;
    if (data.positions.size() > k_limit || data.face_vertices.size() > k_limit)
        complain("more than 2^32 - 5 vertices or face corners; split the model");
    const auto& offsets = data.face_offsets;
    if (offsets.empty() ? !data.face_vertices.empty()
                        : offsets.front() != 0 || offsets.back() != data.face_vertices.size() ||
                              !std::is_sorted(offsets.begin(), offsets.end()))
        complain("face_offsets must ascend from 0 to the size of face_vertices");
    const std::size_t faces = offsets.empty() ? 0 : offsets.size() - 1;
    const auto fits = [](std::size_t size, std::size_t wanted) { return size == 0 || size == wanted; };
    if (!fits(data.face_uvs.size(), data.face_vertices.size())) complain("face_uvs needs one number per face corner");
    if (!fits(data.face_normals.size(), data.face_vertices.size()))
        complain("face_normals needs one number per face corner");
    if (!fits(data.face_material.size(), faces)) complain("face_material needs one number per face");
    if (!fits(data.face_group.size(), faces)) complain("face_group needs one number per face");
    if (!fits(data.face_lines.size(), faces)) complain("face_lines needs one number per face");
    if (!fits(data.vertex_lines.size(), data.positions.size())) complain("vertex_lines needs one number per vertex");
    if (!fits(data.uv_lines.size(), data.uvs.size())) complain("uv_lines needs one number per texture coordinate");
    if (!fits(data.hole_lines.size(), data.holes.size())) complain("hole_lines needs one number per hole");
}

// The first corner whose vertex an earlier corner has, or the face's size.
std::uint32_t repeated_corner(std::span<const std::uint32_t> corners) {
    const std::uint32_t size = count_of(corners.size());
    std::unordered_set<std::uint32_t> seen;
    for (std::uint32_t i = 1; i < size; ++i)
        if (size <= k_small_face ? std::ranges::find(corners.first(i), corners[i]) != corners.begin() + i
                                 : !seen.insert(corners[i]).second || corners[i] == corners[0])
            return i;
    return size;
}

void check_face(const ControlMeshData& data, std::uint32_t f, std::vector<MeshFault>& faults) {
    const std::uint32_t first = data.face_offsets[f], size = data.face_offsets[f + 1] - first;
    const std::uint64_t from = data.first_number, number = f + from;
    const std::span corners(data.face_vertices.data() + first, size);
    const auto add = [&](Kind kind, std::string text) {
        faults.push_back({kind, f, line_at(data.face_lines, f), std::move(text)});
    };
    if (size < 3)
        return add(Kind::face_too_small,
                   fmt::format("face {} has {} corners; it needs 3 or more, or use --repair to drop it", number, size));
    const auto beyond = [&](std::span<const std::uint32_t> numbers, std::size_t limit) {
        return std::find_if(numbers.begin(), numbers.end(), [limit](std::uint32_t n) { return n >= limit; });
    };
    if (const auto it = beyond(corners, data.positions.size()); it != corners.end())
        return add(Kind::vertex_out_of_range,
                   fmt::format("face {} uses {}, but there are {} vertices (numbers start at {}); check the export or "
                               "use --repair to drop the face",
                               number, vertex_name(data, *it), data.positions.size(), from));
    if (const std::uint32_t i = repeated_corner(corners); i != size)
        add(Kind::repeated_vertex,
            fmt::format("face {} has {} twice; {}", number, vertex_name(data, corners[i]), k_repair_advice));
    const auto check_corners = [&](const std::vector<std::uint32_t>& of_corner, std::size_t count, Kind kind,
                                   const char* what, const char* remedy) {
        if (of_corner.empty()) return;
        const std::span numbers(of_corner.data() + first, size);
        if (const auto it = beyond(numbers, count); it != numbers.end())
            add(kind, fmt::format("face {} uses {} {}, but there are {} (numbers start at {}); check the export or use "
                                  "--repair to {}",
                                  number, what, *it + from, count, from, remedy));
    };
    check_corners(data.face_uvs, data.uvs.size(), Kind::uv_out_of_range, "texture coordinate", "put (0, 0)");
    check_corners(data.face_normals, data.normals.size(), Kind::normal_out_of_range, "normal", "drop the normals");
    const auto check_group = [&](const std::vector<std::uint32_t>& of_face, std::size_t count, const char* what) {
        if (!of_face.empty() && of_face[f] >= count)
            add(Kind::group_out_of_range,
                fmt::format("face {} has {} {}, which has no name in the list; check the export or use --repair to "
                            "drop these numbers",
                            number, what, of_face[f]));
    };
    check_group(data.face_material, data.materials.size(), "material");
    check_group(data.face_group, data.groups.size(), "group");
}

void check_vertex(const ControlMeshData& data, std::uint32_t v, std::vector<MeshFault>& faults) {
    const Vec3d& p = data.positions[v];
    if (is_sound_position(p)) return;
    const bool finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    faults.push_back(
        {finite ? Kind::absurd_coordinate : Kind::non_finite_vertex, v, line_at(data.vertex_lines, v),
         fmt::format("vertex {} has a coordinate {}; correct it, or use --repair to drop its faces",
                     std::uint64_t{v} + data.first_number,
                     finite ? fmt::format("beyond {:.0e}", k_max_coordinate) : "that is not a finite number")});
}

std::string crease_name(const ControlMeshData& data, std::uint32_t i) {
    return fmt::format("crease tag {} ({}, {})", std::uint64_t{i} + data.first_number, tag_number(data.creases[i].a),
                       tag_number(data.creases[i].b));
}

void check_tags(const ControlMeshData& data, std::vector<MeshFault>& faults) {
    const std::size_t vertices = data.positions.size(), faces = data.face_offsets.size() - 1;
    const auto last = [](std::size_t count) { return static_cast<std::int64_t>(count) - 1; };
    const auto add = [&](Kind kind, std::uint32_t i, std::uint64_t line, std::string text) {
        faults.push_back({kind, i, line, std::move(text)});
    };
    const auto no_such = [&](const std::string& tag, std::string_view one, std::string_view many, std::size_t count) {
        return fmt::format("{} names a {} that is not there, the last of {} is {}; tags count {} from 0, {}", tag, one,
                           count, last(count), many, k_drop_tag);
    };
    const auto check_sharpness = [&](Kind kind, std::uint32_t i, bool there, const auto& tag, auto&& tag_name) {
        if (!there)
            add(kind, i, tag.line, no_such(tag_name(), "vertex", "vertices", vertices));
        else if (!(tag.sharpness >= 0.0f))  // NaN fails the comparison
            add(kind, i, tag.line,
                fmt::format("{} has sharpness {}; it must be 0 or more, {}", tag_name(), tag.sharpness, k_drop_tag));
    };
    for (std::uint32_t i = 0; i < data.creases.size(); ++i) {
        const auto& tag = data.creases[i];
        check_sharpness(Kind::crease_tag, i, tag.a < vertices && tag.b < vertices, tag,
                        [&] { return crease_name(data, i); });
    }
    for (std::uint32_t i = 0; i < data.corners.size(); ++i) {
        const auto& tag = data.corners[i];
        check_sharpness(Kind::corner_tag, i, tag.vertex < vertices, tag, [&] {
            return fmt::format("corner tag {} ({})", std::uint64_t{i} + data.first_number, tag_number(tag.vertex));
        });
    }
    for (std::uint32_t i = 0; i < data.corner_angles.size(); ++i) {
        const auto& tag = data.corner_angles[i];
        if (tag.vertex >= vertices)
            add(Kind::corner_angle_tag, i, tag.line, no_such(angle_tag_name(data, i), "vertex", "vertices", vertices));
        else if (tag.face >= faces)
            add(Kind::corner_angle_tag, i, tag.line, no_such(angle_tag_name(data, i), "face", "faces", faces));
        else if (!is_sector_angle(tag.angle))
            add(Kind::corner_angle_tag, i, tag.line,
                fmt::format("{} has {} degrees; they must be above 0 and below 360, and not 180, {}",
                            angle_tag_name(data, i), degrees(tag.angle), k_drop_tag));
    }
    for (std::uint32_t i = 0; i < data.holes.size(); ++i)
        if (data.holes[i] >= faces)
            add(Kind::hole_tag, i, line_at(data.hole_lines, i),
                fmt::format("hole tag {} names face {}, but there are {} faces; tags count faces from 0, {}",
                            std::uint64_t{i} + data.first_number, tag_number(data.holes[i]), faces, k_drop_tag));
}

void sort_faults(std::vector<MeshFault>& faults) {
    std::ranges::stable_sort(faults, {}, [](const MeshFault& fault) { return std::pair(fault.kind, fault.element); });
}

// Whether a face is a line or a point within the precision of doubles.
bool is_flat(const ControlMeshData& data, std::uint32_t f) {
    const std::uint32_t first = data.face_offsets[f];
    const auto point = [&](std::uint32_t h) -> const Vec3d& { return data.positions[data.face_vertices[h]]; };
    Vec3d area(0.0);
    double perimeter = 0;
    for (std::uint32_t h = first; h < data.face_offsets[f + 1]; ++h) {
        const Vec3d &p = point(h), &q = point(next_corner(data, f, h));
        area += glm::cross(p - point(first), q - point(first));
        perimeter += glm::distance(p, q);
    }
    return glm::length(area) <= k_zero_area * perimeter * perimeter;
}

// Faults of single elements: sizes, coordinates, faces, attributes, tags (except for the edges of creases).
std::vector<MeshFault> element_faults(const ControlMeshData& data) {
    std::vector<MeshFault> faults;
    check_sizes(data, faults);
    if (!faults.empty()) return faults;
    if (data.face_offsets.size() < 2) {
        // Warnings from reading or repairing may explain this.
        std::string text = "there are no faces; a control mesh needs at least one";
        for (const std::string& warning : data.warnings) text += "\n  " + warning;
        return {{Kind::no_faces, 0, 0, text}};
    }
    for (std::uint32_t v = 0; v < data.positions.size(); ++v) check_vertex(data, v, faults);
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) check_face(data, f, faults);
    for (std::uint32_t i = 0; i < data.uvs.size(); ++i)
        if (!is_sound_uv(data.uvs[i]))
            faults.push_back({Kind::non_finite_uv, i, line_at(data.uv_lines, i),
                              fmt::format("texture coordinate {} is not finite or beyond {:g}; correct it, or use "
                                          "--repair to put (0, 0)",
                                          std::uint64_t{i} + data.first_number, k_max_uv)});
    check_tags(data, faults);
    sort_faults(faults);
    return faults;
}

// Faults of edges, duplicate faces, and tags that name no edge or face corner. Needs data without element faults.
std::vector<MeshFault> edge_faults(const ControlMeshData& data, std::span<const EdgeUse> sorted_uses,
                                   const MeshLinks& links) {
    std::vector<MeshFault> faults;
    const auto add = [&](Kind kind, std::uint32_t element, std::uint64_t line, std::string text) {
        faults.push_back({kind, element, line, std::move(text)});
    };
    const std::size_t uses = links.manifold_edges ? 0 : sorted_uses.size();
    for (std::size_t i = 0, count = 1; i < uses; i += count) {
        const EdgeUse& use = sorted_uses[i];
        for (count = 1; i + count < uses && use.same_edge(sorted_uses[i + count]);) ++count;
        const std::uint32_t face = links.face[use.halfedge];
        const auto add_edge = [&](Kind kind, fmt::format_string<std::string, std::string, std::uint64_t> text) {
            add(kind, face, line_at(data.face_lines, face),
                fmt::format(text, vertex_name(data, use.low), vertex_name(data, use.high),
                            std::uint64_t{face} + data.first_number));
        };
        if (count > 2)
            add_edge(Kind::non_manifold_edge,
                     "the edge between {} and {} of face {} has more than two faces; correct it in the modeller or use "
                     "--repair to split it into boundaries");
        else if (count == 2 && data.face_vertices[use.halfedge] == data.face_vertices[sorted_uses[i + 1].halfedge])
            add_edge(Kind::opposite_orientation,
                     "the two faces at the edge between {} and {} (one is face {}) run along it in the same "
                     "direction; flip one, or use --repair to orient all faces alike");
    }
    // Two faces with one cycle use the same edges in the same direction: without edge faults there are no duplicates.
    if (!faults.empty())
        for (const auto& [face, first] : duplicate_faces(data))
            add(Kind::duplicate_face, face, line_at(data.face_lines, face),
                fmt::format("face {} has the same vertices as {}; delete one, or use --repair",
                            std::uint64_t{face} + data.first_number, face_name(data, first)));
    for (std::uint32_t i = 0; i < data.creases.size(); ++i)
        if (const auto& tag = data.creases[i]; !find_edge(sorted_uses, tag.a, tag.b))
            add(Kind::crease_tag, i, tag.line,
                fmt::format("{}: no face has an edge between {} and {}; tags count vertices from 0, {}",
                            crease_name(data, i), vertex_name(data, tag.a), vertex_name(data, tag.b), k_drop_tag));
    for (std::uint32_t i = 0; i < data.corner_angles.size(); ++i)
        if (const auto& tag = data.corner_angles[i]; face_corner(data, tag.face, tag.vertex) == HalfedgeId::none)
            add(Kind::corner_angle_tag, i, tag.line,
                fmt::format("{}: {} does not touch {}; tags count vertices and faces from 0, {}",
                            angle_tag_name(data, i), face_name(data, tag.face), vertex_name(data, tag.vertex),
                            k_drop_tag));
    sort_faults(faults);
    return faults;
}

// Non-manifold vertices. Needs data without other faults.
std::vector<MeshFault> vertex_faults(const ControlMeshData& data, const MeshLinks& links) {
    std::vector<MeshFault> faults;
    for (std::uint32_t v = 0; v < data.positions.size(); ++v) {
        const std::uint32_t all = links.vertex_face_count[v], start = links.vertex_halfedge[v];
        std::uint32_t fan = 0;  // number of corners, counter-clockwise from the first
        for (std::uint32_t h = start; h != HalfedgeId::none && (fan == 0 || h != start); ++fan)
            h = links.twin[prev_corner(data, links.face[h], h)];
        if (fan != all)
            faults.push_back({Kind::non_manifold_vertex, v, line_at(data.vertex_lines, v),
                              fmt::format("the {} faces at vertex {} are not one fan, they only touch there (one is "
                                          "{}); {} to split it",
                                          all, std::uint64_t{v} + data.first_number,
                                          face_name(data, links.face[links.vertex_halfedge[v]]), k_repair_advice)});
    }
    return faults;
}

}  // namespace

std::string vertex_name(const ControlMeshData& data, std::uint32_t v) {
    if (v == VertexId::none)
        return "a vertex that no number can name (it counts back before the first one, or has too many digits)";
    return with_line(fmt::format("vertex {}", std::uint64_t{v} + data.first_number), line_at(data.vertex_lines, v));
}

std::string face_name(const ControlMeshData& data, std::uint32_t f) {
    return with_line(fmt::format("face {}", std::uint64_t{f} + data.first_number), line_at(data.face_lines, f));
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

std::vector<DuplicateFace> duplicate_faces(const ControlMeshData& data) {
    std::vector<DuplicateFace> duplicates;
    std::unordered_map<std::u32string, std::uint32_t> first;  // by the cycle, starting at its lowest vertex
    for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
        std::u32string cycle(data.face_vertices.begin() + data.face_offsets[f],
                             data.face_vertices.begin() + data.face_offsets[f + 1]);
        std::ranges::rotate(cycle, std::ranges::min_element(cycle));
        if (const auto [at, is_new] = first.try_emplace(std::move(cycle), f); !is_new)
            duplicates.push_back({f, at->second});
    }
    return duplicates;
}

std::vector<MeshFault> find_faults(const ControlMeshData& data, const RunContext& context,
                                   std::vector<EdgeUse>& sorted_uses, MeshLinks& links) {
    std::vector<MeshFault> faults = element_faults(data);
    context.report("build", 0.2);
    if (!faults.empty()) return faults;
    sorted_uses = sorted_edge_uses(data);
    context.report("build", 0.5);
    links = link_mesh(data, sorted_uses);
    faults = edge_faults(data, sorted_uses, links);
    return faults.empty() ? vertex_faults(data, links) : faults;
}

std::vector<std::string> find_oddities(const ControlMeshData& data, const MeshLinks& links) {
    const auto isolated_vertices = std::ranges::count(links.vertex_halfedge, HalfedgeId::none);
    std::vector<std::string> oddities;
    if (isolated_vertices != 0)
        oddities.push_back(fmt::format("{} of {} vertices belong to no face; they are ignored", isolated_vertices,
                                       data.positions.size()));
    const std::uint32_t faces = count_of(data.face_offsets.size() - 1);
    std::vector<std::uint32_t> flat;
    for (std::uint32_t f = 0; f < faces; ++f)
        if (is_flat(data, f)) flat.push_back(f);
    if (!flat.empty())
        oddities.push_back(
            // After a repair, numbers differ from the source's; lines do not.
            fmt::format("{} of {} faces have zero area (the first is {}); normals are undefined there", flat.size(),
                        faces,
                        flat[0] < data.face_lines.size() && data.face_lines[flat[0]] != 0
                            ? fmt::format("on line {}", data.face_lines[flat[0]])
                            : face_name(data, flat[0])));
    const auto odd_normals = std::ranges::count_if(
        data.normals, [](const Vec3d& n) { return !std::isfinite(n.x) || !std::isfinite(n.y) || !std::isfinite(n.z); });
    if (odd_normals != 0)
        oddities.push_back(fmt::format("{} normals are not finite; normals as read are not used", odd_normals));
    if (const auto oddity = unwelded_edges(data, links.twin)) oddities.push_back(*oddity);
    return oddities;
}

}  // namespace detail

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
    static_assert(std::size(k_names) == static_cast<std::size_t>(MeshFaultKind::non_manifold_vertex) + 1);
    return k_names[static_cast<std::size_t>(kind)];
}

std::vector<MeshFault> find_faults(const ControlMeshData& data) {
    std::vector<detail::EdgeUse> uses;
    detail::MeshLinks links;
    std::vector<MeshFault> faults = detail::find_faults(data, {}, uses, links);
    if (!faults.empty() || data.corner_angles.empty()) return faults;
    ControlMeshData others = data;
    others.corner_angles.clear();
    return detail::tagged_angles(ControlMesh::build(std::move(others)), data).faults;
}

std::vector<std::string> find_oddities(const ControlMeshData& data) {
    ControlMeshData without_warnings = data;
    without_warnings.warnings.clear();
    return ControlMesh::build(std::move(without_warnings)).warnings();
}

}  // namespace tetrakis
