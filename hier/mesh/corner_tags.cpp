#include "corner_tags.hpp"

#include "../base/ids.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <unordered_map>
#include <utility>

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t k_none = HalfedgeId::none;
// Sharp edges from which a vertex is a corner.
constexpr int k_corner_edges = 3;

/// Sectors around the vertices that have tags.
class Sectors {
  public:
    Sectors(const ControlMeshData& data, const MeshLinks& links) : data_(data), links_(links) {
        for (const auto& tag : data.corner_angles) sharpness_.try_emplace(tag.vertex, 0.0f);
        // Later tags replace earlier ones, as in the mesh.
        for (const auto& tag : data.corners)
            if (const auto at = sharpness_.find(tag.vertex); at != sharpness_.end()) at->second = tag.sharpness;
        for (const auto& tag : data.creases)
            if (sharpness_.contains(tag.a) || sharpness_.contains(tag.b))
                creases_[std::minmax(tag.a, tag.b)] = tag.sharpness;
    }

    bool is_sharp(std::uint32_t h) const {
        if (links_.twin[h] == k_none) return true;
        const auto at = creases_.find(std::minmax(origin(h), origin(next(h))));
        return at != creases_.end() && at->second > 0;
    }
    bool is_corner(std::uint32_t v) const {
        if (sharpness_.at(v) > 0) return true;
        const std::uint32_t first = links_.vertex_halfedge[v];
        if (data_.boundary_rule == BoundaryRule::edge_and_corner && links_.twin[first] == k_none &&
            links_.vertex_face_count[v] == 1)
            return true;
        int sharp = 0;
        for (std::uint32_t h = first; h != k_none;) {
            sharp += is_sharp(h) ? 1 : 0;
            h = links_.twin[prev(h)];
            if (h == first) break;
            if (h == k_none) ++sharp;  // the boundary edge that ends the fan
        }
        return sharp >= k_corner_edges;
    }
    /// The half-edges of the sector around the one given, counter-clockwise; the same list from each of them.
    std::vector<std::uint32_t> around(std::uint32_t h) const {
        std::uint32_t start = h, lowest = h;
        while (!is_sharp(start)) {
            start = next(links_.twin[start]);
            lowest = std::min(lowest, start);
            if (start == h) {
                start = lowest;
                break;
            }
        }
        std::vector<std::uint32_t> sector;
        for (std::uint32_t at = start;;) {
            sector.push_back(at);
            if (is_sharp(prev(at))) return sector;
            at = links_.twin[prev(at)];
            if (at == start) return sector;
        }
    }

  private:
    std::uint32_t origin(std::uint32_t h) const { return data_.face_vertices[h]; }
    std::uint32_t next(std::uint32_t h) const { return next_corner(data_, links_.face[h], h); }
    std::uint32_t prev(std::uint32_t h) const { return prev_corner(data_, links_.face[h], h); }

    const ControlMeshData& data_;
    const MeshLinks& links_;
    std::unordered_map<std::uint32_t, float> sharpness_;  ///< of the vertices that have tags
    std::map<std::pair<std::uint32_t, std::uint32_t>, float> creases_;
};

}  // namespace

TaggedAngles tagged_angles(const ControlMeshData& data, const MeshLinks& links) {
    TaggedAngles result;
    if (data.corner_angles.empty()) return result;
    const Sectors sectors(data, links);
    std::unordered_map<std::uint32_t, std::uint32_t> tag_of;  // by a sector's first half-edge
    for (std::uint32_t i = 0; i < data.corner_angles.size(); ++i) {
        const auto& tag = data.corner_angles[i];
        const std::vector<std::uint32_t> sector = sectors.around(face_corner(data, tag.face, tag.vertex));
        const auto [at, is_new] = tag_of.try_emplace(sector.front(), i);
        const auto& before = data.corner_angles[at->second];
        if (!is_new && before.angle != tag.angle)
            result.faults.push_back(make_fault(
                data, MeshFaultKind::corner_angle_tag, i,
                fmt::format("{} has {} degrees, but tag {}{} has {} for the same sector (the faces between two sharp "
                            "edges); leave one, {}",
                            angle_tag_name(data, i), degrees(tag.angle), std::uint64_t{at->second} + data.first_number,
                            before.line == 0 ? "" : fmt::format(" (line {})", before.line), degrees(before.angle),
                            k_drop_tag)));
        if (!sectors.is_corner(tag.vertex)) {
            result.idle.push_back(i);
            continue;
        }
        result.angle.resize(data.face_vertices.size(), 0.0);
        if (is_new)
            for (const std::uint32_t h : sector) result.angle[h] = tag.angle;
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
    return k_none;
}

}  // namespace tetrakis::detail
