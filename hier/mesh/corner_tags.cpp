#include "corner_tags.hpp"

#include "../base/ids.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <unordered_map>
#include <vector>

namespace tetrakis::detail {

namespace {

bool is_on_crease(const ControlMesh& mesh, HalfedgeId h) { return mesh.sharpness(mesh.edge(h)) > 0; }

bool is_corner_vertex(const ControlMesh& mesh, VertexId v) {
    constexpr int k_corner_edges = 3;         // number of sharp edges from which a vertex is a corner
    int sharp = mesh.is_boundary(v) ? 1 : 0;  // the boundary edge that ends the fan
    const HalfedgeId first = mesh.vertex_halfedge(v);
    HalfedgeId h = first;
    do {
        sharp += is_on_crease(mesh, h) ? 1 : 0;
        h = mesh.ccw_outgoing(h);
    } while (h.valid() && h != first);
    return mesh.sharpness(v) > 0 || sharp >= k_corner_edges;
}

/// The half-edges of the sector of a half-edge, counter-clockwise; the same list for each half-edge of the sector.
std::vector<HalfedgeId> sector_around(const ControlMesh& mesh, HalfedgeId h) {
    HalfedgeId start = h, lowest = h;
    while (!is_on_crease(mesh, start)) {
        start = mesh.cw_outgoing(start);
        lowest = std::min(lowest, start);
        if (start == h) {
            start = lowest;
            break;
        }
    }
    std::vector<HalfedgeId> sector;
    for (HalfedgeId at = start; sector.empty() || at != start; at = mesh.ccw_outgoing(at)) {
        sector.push_back(at);
        if (is_on_crease(mesh, mesh.prev(at))) break;
    }
    return sector;
}

}  // namespace

TaggedAngles tagged_angles(const ControlMesh& mesh, const ControlMeshData& data) {
    TaggedAngles result;
    std::unordered_map<std::uint32_t, std::uint32_t> tag_of;  // by the first half-edge of a sector
    for (std::uint32_t i = 0; i < data.corner_angles.size(); ++i) {
        const auto& tag = data.corner_angles[i];
        const auto sector = sector_around(mesh, HalfedgeId(face_corner(data, tag.face, tag.vertex)));
        const auto [at, is_new] = tag_of.try_emplace(sector.front().value, i);
        const auto& before = data.corner_angles[at->second];
        if (!is_new && before.angle != tag.angle)
            result.faults.push_back(
                {MeshFaultKind::corner_angle_tag, i, tag.line,
                 fmt::format("{} has {} degrees, but tag {}{} has {} for the same sector (the faces between two sharp "
                             "edges); leave one, {}",
                             angle_tag_name(data, i), degrees(tag.angle), std::uint64_t{at->second} + data.first_number,
                             before.line == 0 ? "" : fmt::format(" (line {})", before.line), degrees(before.angle),
                             k_drop_tag)});
        if (!is_corner_vertex(mesh, VertexId(tag.vertex))) {
            result.idle.push_back(i);
            continue;
        }
        result.angle.resize(data.face_vertices.size(), 0.0);
        if (is_new)
            for (const HalfedgeId h : sector) result.angle[h.value] = tag.angle;
    }
    return result;
}

std::optional<std::string> idle_angles(const ControlMeshData& data, const TaggedAngles& angles) {
    if (angles.idle.empty()) return std::nullopt;
    const auto& first = data.corner_angles[angles.idle.front()];
    return fmt::format(
        "{} of {} corner angle tags are at vertices that are no corners (the first is at {}{}); they have no effect",
        angles.idle.size(), data.corner_angles.size(), vertex_name(data, first.vertex),
        first.line == 0 ? "" : fmt::format(", tagged on line {}", first.line));
}

std::string tag_number(std::uint32_t n) {
    return n == VertexId::none ? "a number below 0 or too large for any mesh" : std::to_string(n);
}

std::string angle_tag_name(const ControlMeshData& data, std::uint32_t i) {
    return fmt::format("corner angle tag {} (vertex {}, face {})", std::uint64_t{i} + data.first_number,
                       tag_number(data.corner_angles[i].vertex), tag_number(data.corner_angles[i].face));
}

bool is_sector_angle(double radians) {
    return radians > 0 && radians < 2 * std::numbers::pi && radians != std::numbers::pi;
}

std::string degrees(double radians) { return fmt::format("{:.9g}", radians * 180 / std::numbers::pi); }

std::uint32_t face_corner(const ControlMeshData& data, std::uint32_t face, std::uint32_t vertex) {
    for (std::uint32_t h = data.face_offsets[face]; h < data.face_offsets[face + 1]; ++h)
        if (data.face_vertices[h] == vertex) return h;
    return HalfedgeId::none;
}

}  // namespace tetrakis::detail
