#include "tetrakis/refine/uv_mesh.hpp"

#include "tetrakis/schemes/sharpness.hpp"

#include <algorithm>
#include <cassert>
#include <compare>
#include <vector>

namespace tetrakis {

namespace {

bool is_seam(const ControlMesh& mesh, HalfedgeId h) {
    const HalfedgeId t = mesh.twin(h);
    return !t.valid() || mesh.uv_index(h) != mesh.uv_index(mesh.next(t)) ||
           mesh.uv_index(mesh.next(h)) != mesh.uv_index(t);
}

}  // namespace

ControlMesh uv_mesh(const ControlMesh& mesh) {
    assert(mesh.has_uvs());
    ControlMeshData data;
    data.source = mesh.data().source;
    data.first_number = mesh.data().first_number;
    data.face_lines = mesh.data().face_lines;
    data.face_offsets = mesh.data().face_offsets;
    data.crease_method = mesh.crease_method();
    data.boundary_rule = mesh.face_varying_rule() == FaceVaryingRule::corners_and_edges ? BoundaryRule::edge_and_corner
                                                                                        : BoundaryRule::edge_only;
    // One point per fan of corners around a vertex that no seam cuts.
    struct Fan {
        std::uint32_t vertex, uv, number;
        auto operator<=>(const Fan&) const = default;
    };
    std::vector<Fan> fans;
    data.face_vertices.assign(mesh.halfedge_count(), HalfedgeId::none);
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        if (data.face_vertices[i] != HalfedgeId::none) continue;
        const HalfedgeId start(i);
        const auto number = static_cast<std::uint32_t>(data.positions.size());
        const Vec2d& uv = mesh.data().uvs[mesh.uv_index(start)];
        data.positions.emplace_back(uv.x, uv.y, 0.0);
        fans.push_back({mesh.origin(start).value, mesh.uv_index(start), number});
        std::uint32_t faces = 0;
        // Clockwise to the seam that starts the fan, if there is one; then counter-clockwise over the fan.
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
        const VertexId v = mesh.origin(start);
        if (is_sharp(mesh.sharpness(v)) && !mesh.is_boundary(v) && faces == mesh.face_valence(v) &&
            !is_seam(mesh, first))
            data.corners.push_back({number, mesh.sharpness(v)});
    }
    // Where several fans share a UV, charts touch in a point, which has to stay one: it stays where it is.
    std::sort(fans.begin(), fans.end());
    for (std::size_t i = 0; i < fans.size(); ++i) {
        const auto touches = [&](std::size_t j) {
            return j < fans.size() && fans[i].vertex == fans[j].vertex && fans[i].uv == fans[j].uv;
        };
        if (touches(i + 1) || (i > 0 && touches(i - 1))) data.corners.push_back({fans[i].number, k_infinite_sharpness});
    }
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        const HalfedgeId h = mesh.edge_halfedge(EdgeId(e));
        const float s = mesh.sharpness(EdgeId(e));
        if (is_sharp(s) && !is_seam(mesh, h))
            data.creases.push_back({data.face_vertices[h.value], data.face_vertices[mesh.next(h).value], s});
    }
    return ControlMesh::build(std::move(data));
}

}  // namespace tetrakis
