#include "corner_cell.hpp"

#include <algorithm>
#include <initializer_list>
#include <tuple>

namespace tetrakis {

namespace {

bool is_hole(const ControlMesh& mesh, HalfedgeId h) { return mesh.is_hole(mesh.face(h)); }

/// The canonical one of several addresses of a point. The first has a root; addresses without a root are ignored.
Site best(const ControlMesh& mesh, std::initializer_list<Site> addresses) {
    return *std::ranges::min_element(addresses, {}, [&](const Site& site) {
        return std::tuple(!site.root.valid() || is_hole(mesh, site.root), site.root);
    });
}

Site at_vertex(const ControlMesh& mesh, VertexId v) {
    const HalfedgeId first = mesh.vertex_halfedge(v);
    HalfedgeId h = first;
    while (is_hole(mesh, h)) {
        h = mesh.ccw_outgoing(h);
        if (!h.valid() || h == first) return {first, {0, 0}, 0};
    }
    return {h, {0, 0}, 0};
}

/// The middle of the edge of h: m(h) = (1, 0) of Q(h) = (0, 1) of Q(next h), and the same from the twin's side.
Site at_edge_middle(const ControlMesh& mesh, HalfedgeId h) {
    const HalfedgeId t = mesh.twin(h);
    const HalfedgeId beyond = t.valid() ? mesh.next(t) : HalfedgeId{};
    return best(mesh, {{h, {1, 0}, 0}, {mesh.next(h), {0, 1}, 0}, {t, {1, 0}, 0}, {beyond, {0, 1}, 0}});
}

}  // namespace

Site detail::canonical_on_side(const ControlMesh& mesh, const Site& minimal) {
    const auto [root, at, level] = minimal;
    if (level == 0) {
        if (at == LatticePoint{0, 0}) return at_vertex(mesh, mesh.origin(root));
        if (at == LatticePoint{1, 1}) return {mesh.face_halfedge(mesh.face(root)), {1, 1}, 0};
        return at_edge_middle(mesh, at.x == 1 ? root : mesh.prev(root));
    }
    const std::uint32_t n = 1u << level;
    // This point is no corner of its cell, so it lies on one side only.
    const CellSide side = at.y == 0   ? CellSide::edge
                          : at.x == 0 ? CellSide::prev_edge
                          : at.x == n ? CellSide::next_cell
                                      : CellSide::prev_cell;
    const HalfedgeId other = across(mesh, root, side);
    return best(mesh, {minimal, {other, {at.y, at.x}, level}});
}

Site triangle_vertex_site(const ControlMesh& mesh, VertexId v) {
    const HalfedgeId h = mesh.vertex_halfedge(v);
    if (!h.valid()) return {};
    const std::uint32_t corner = h.value % 3;
    return {HalfedgeId(h.value - corner), {corner == 1 ? 1u : 0u, corner == 2 ? 1u : 0u}, 0};
}

TriangleWeights across(const ControlMesh& mesh, HalfedgeId h, const TriangleWeights& weight) {
    const std::uint32_t side = h.value % 3, twin = mesh.twin(h).value % 3;
    const std::int64_t beyond = weight[(side + 2) % 3];
    TriangleWeights there;
    there[twin] = weight[(side + 1) % 3] + beyond;
    there[(twin + 1) % 3] = weight[side] + beyond;
    there[(twin + 2) % 3] = -beyond;
    return there;
}

Site canonical_triangle_site(const ControlMesh& mesh, FaceId face, TriangleWeights weight, int level) {
    for (std::uint32_t side = 0; side < 3; ++side) {
        if (weight[(side + 2) % 3] != 0) continue;
        const HalfedgeId h(3 * face.value + side), twin = mesh.twin(h);
        if (level == 0) return triangle_vertex_site(mesh, mesh.origin(weight[side] != 0 ? h : mesh.next(h)));
        if (!twin.valid() || mesh.face(twin) > face) break;
        weight = across(mesh, h, weight);
        face = mesh.face(twin);
        break;
    }
    return {HalfedgeId(3 * face.value),
            {static_cast<std::uint32_t>(weight[1]), static_cast<std::uint32_t>(weight[2])},
            static_cast<std::uint8_t>(level)};
}

Site canonical_triangle_site(const ControlMesh& mesh, const Site& site) {
    const Site minimal = minimal_level(site);
    const std::int64_t x = minimal.at.x, y = minimal.at.y, end = std::int64_t{1} << minimal.level;
    if (x != 0 && y != 0 && x + y != end) return minimal;
    return canonical_triangle_site(mesh, mesh.face(minimal.root), {end - x - y, x, y}, minimal.level);
}

}  // namespace tetrakis
