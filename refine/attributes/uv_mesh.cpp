#include "uv_mesh.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../rules/corner_angles.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cassert>
#include <compare>
#include <span>
#include <tuple>
#include <vector>

namespace tetrakis {

namespace {

bool is_seam(const ControlMesh& mesh, HalfedgeId h) {
    const HalfedgeId t = mesh.twin(h);
    return !t.valid() || mesh.uv_index(h) != mesh.uv_index(mesh.next(t)) ||
           mesh.uv_index(mesh.next(h)) != mesh.uv_index(t);
}

/// Number of faces around the half-edge's origin, from its own face to the edges at which `ends` is true.
template <class Ends>
std::uint32_t sector_size(const ControlMesh& mesh, HalfedgeId h, Ends&& ends) {
    std::uint32_t faces = 1;
    for (HalfedgeId at = h; !ends(mesh.prev(at)); ++faces)
        if ((at = mesh.ccw_outgoing(at)) == h) return faces;
    for (HalfedgeId at = h; !ends(at); ++faces) at = mesh.cw_outgoing(at);
    return faces;
}

/// The corners around a vertex between two seams; they become one point.
struct Fan {
    std::uint32_t vertex, uv, number, faces;
    bool closed;  // no seam at the vertex
    auto operator<=>(const Fan&) const = default;
};

/// Whether the rule fixes all UVs of a vertex. Source: OpenSubdiv's subdivision manual, face-varying interpolation
/// rules; tests compare the cases with that library.
/// @param fans  fans of the vertex, in the order of their UVs
bool stays(const ControlMesh& mesh, FaceVaryingRule rule, std::span<const Fan> fans) {
    if (fans[0].closed) return false;
    if (rule == FaceVaryingRule::boundaries) return true;
    if (rule != FaceVaryingRule::corners_plus1 && rule != FaceVaryingRule::corners_plus2) return false;
    std::size_t uvs = 1;
    for (std::size_t i = 1; i < fans.size(); ++i) uvs += fans[i].uv != fans[i - 1].uv;
    if (uvs > 2) return true;
    if (rule == FaceVaryingRule::corners_plus1) return false;
    const bool dart = uvs == 1 && !mesh.is_boundary(VertexId(fans[0].vertex));
    return dart || (uvs == 2 && std::ranges::any_of(fans, [](const Fan& fan) { return fan.faces == 1; }));
}

}  // namespace

ControlMesh uv_mesh(const ControlMesh& mesh, const RuleOptions& rules) {
    assert(mesh.has_uvs());
    ControlMeshData data;
    data.source = mesh.data().source;
    data.first_number = mesh.data().first_number;
    data.face_lines = mesh.data().face_lines;
    data.face_offsets = mesh.data().face_offsets;
    data.crease_method = mesh.crease_method();
    const FaceVaryingRule rule = mesh.face_varying_rule();
    data.boundary_rule = rule == FaceVaryingRule::smooth_all ? BoundaryRule::edge_only : BoundaryRule::edge_and_corner;
    std::vector<Fan> fans;
    data.face_vertices.assign(mesh.halfedge_count(), HalfedgeId::none);
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        if (data.face_vertices[i] != HalfedgeId::none) continue;
        const HalfedgeId start(i);
        const auto number = static_cast<std::uint32_t>(data.positions.size());
        const Vec2d& uv = mesh.data().uvs[mesh.uv_index(start)];
        data.positions.emplace_back(uv.x, uv.y, 0.0);
        std::uint32_t faces = 0;
        // Clockwise to the seam that starts the fan, if there is one, then counter-clockwise over the fan.
        HalfedgeId first = start;
        while (!is_seam(mesh, first)) {
            first = mesh.cw_outgoing(first);
            if (first == start) break;
        }
        HalfedgeId h = first;
        do {
            data.face_vertices[h.value] = number;
            ++faces;
            if (is_seam(mesh, mesh.prev(h))) break;
            h = mesh.ccw_outgoing(h);
        } while (h != first);
        fans.push_back({mesh.origin(start).value, mesh.uv_index(start), number, faces, !is_seam(mesh, first)});
        const VertexId v = mesh.origin(start);
        if (is_sharp(mesh.sharpness(v))) data.corners.push_back({number, mesh.sharpness(v)});
    }
    std::sort(fans.begin(), fans.end());
    for (std::size_t begin = 0, end = 0; begin < fans.size(); begin = end) {
        while (end < fans.size() && fans[end].vertex == fans[begin].vertex) ++end;
        const std::span at_vertex(fans.data() + begin, end - begin);
        const bool all = stays(mesh, rule, at_vertex);
        for (std::size_t i = 0; i < at_vertex.size(); ++i) {
            // If several fans share a UV, charts touch in a point. It must remain one point, so it is fixed.
            const auto touches = [&](std::size_t j) {
                return j < at_vertex.size() && at_vertex[j].uv == at_vertex[i].uv;
            };
            if (all || touches(i + 1) || (i > 0 && touches(i - 1)))
                data.corners.push_back({at_vertex[i].number, k_infinite_sharpness});
        }
    }
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        const HalfedgeId h = mesh.edge_halfedge(EdgeId(e));
        const float s = mesh.sharpness(EdgeId(e));
        if (is_sharp(s) && !is_seam(mesh, h))
            data.creases.push_back({data.face_vertices[h.value], data.face_vertices[mesh.next(h).value], s});
    }
    const std::vector<double> angles = detail::corner_angles(mesh, rules);
    for (std::uint32_t i = 0; i < angles.size(); ++i) {
        if (angles[i] == 0) continue;
        const HalfedgeId h(i);
        const auto sharp = [&](HalfedgeId at) { return is_sharp(mesh.sharpness(mesh.edge(at))); };
        const std::uint32_t all = sector_size(mesh, h, sharp),
                            part = sector_size(mesh, h, [&](HalfedgeId at) { return sharp(at) || is_seam(mesh, at); });
        const double angle = part == all ? angles[i] : usable_corner_angle(angles[i] * part / all);
        data.corner_angles.push_back({data.face_vertices[i], mesh.face(h).value, angle});
    }
    return ControlMesh::build(std::move(data));
}

RuleOptions detail::chart_rules(RuleOptions rules) {
    rules.measure_corner_angles = false;
    return rules;
}

std::optional<ControlMesh> detail::without_ignored_tags(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                        const RuleOptions& rules) {
    if (!ignores_creases(scheme, rules) || (mesh.data().creases.empty() && mesh.data().corners.empty()))
        return std::nullopt;
    ControlMeshData data = mesh.data();
    data.creases.clear();
    std::erase_if(data.corners, [&](const auto& corner) { return !mesh.is_boundary(VertexId(corner.vertex)); });
    return ControlMesh::build(std::move(data));
}

detail::FaceUvs detail::number_uvs(std::span<const std::uint32_t> face_vertices, std::span<const Vec2d> values) {
    struct Corner {
        std::uint32_t vertex, number;
        Vec2d uv;
    };
    const auto count = static_cast<std::uint32_t>(values.size());
    std::vector<Corner> corners(count);
    for_each_index(count, [&](std::uint32_t c) { corners[c] = {face_vertices[c], c, values[c]}; });
    oneapi::tbb::parallel_sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
        return std::tie(a.vertex, a.uv.x, a.uv.y, a.number) < std::tie(b.vertex, b.uv.x, b.uv.y, b.number);
    });
    FaceUvs result;
    result.face_uvs.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const Corner& c = corners[i];
        if (i == 0 || corners[i - 1].vertex != c.vertex || corners[i - 1].uv != c.uv) result.uvs.push_back(c.uv);
        result.face_uvs[c.number] = static_cast<std::uint32_t>(result.uvs.size() - 1);
    }
    return result;
}

}  // namespace tetrakis
