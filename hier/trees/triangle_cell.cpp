#include "triangle_cell.hpp"

#include "../forest/corner_cell.hpp"

#include <algorithm>
#include <array>

namespace tetrakis {

namespace {

HalfedgeId corner_halfedge(HalfedgeId root, int corner) {
    return HalfedgeId(root.value + static_cast<std::uint32_t>(corner));
}

// The control corner that a level-0 point is.
int corner_of(LatticePoint at) { return at.x != 0 ? 1 : at.y != 0 ? 2 : 0; }

LatticePoint corner_point(int corner) {
    return {corner == 1 ? std::uint32_t{1} : 0, corner == 2 ? std::uint32_t{1} : 0};
}

// The side a point of level > 0 lies on; -1 inside.
int side_of(const Site& site) {
    if (site.at.y == 0) return 0;
    if (site.at.x == 0) return 2;
    return site.at.x + site.at.y == std::uint32_t{1} << site.level ? 1 : -1;
}

Site canonical_on_side(const ControlMesh& mesh, const Site& site, int side) {
    const HalfedgeId twin = mesh.twin(corner_halfedge(site.root, side));
    if (!twin.valid() || mesh.face_halfedge(mesh.face(twin)) > site.root) return site;
    const auto there = cross_triangle_side(mesh, side, site.level, {site.root, site.at.x, site.at.y});
    return {there->root, {static_cast<std::uint32_t>(there->x), static_cast<std::uint32_t>(there->y)}, site.level};
}

Site corner_site(const ControlMesh& mesh, HalfedgeId outgoing) {
    const HalfedgeId root = mesh.face_halfedge(mesh.face(outgoing));
    return {root, corner_point(static_cast<int>(outgoing.value - root.value)), 0};
}

}  // namespace

std::optional<TrianglePoint> cross_triangle_side(const ControlMesh& mesh, int side, int level,
                                                 const TrianglePoint& point) {
    const HalfedgeId twin = mesh.twin(corner_halfedge(point.root, side));
    if (!twin.valid()) return std::nullopt;
    const HalfedgeId root = mesh.face_halfedge(mesh.face(twin));
    const int other = static_cast<int>(twin.value - root.value);
    // Barycentric weights: with the corners a, b of the side and its opposite corner c, the next root's third corner is
    // c' = a + b - c in the continued lattice, so alpha a + beta b + gamma c = (alpha + gamma) a + (beta + gamma) b -
    // gamma c'.
    const std::array<std::int64_t, 3> weight = {(std::int64_t{1} << level) - point.x - point.y, point.x, point.y};
    const std::int64_t alpha = weight[side], beta = weight[(side + 1) % 3], gamma = weight[(side + 2) % 3];
    std::array<std::int64_t, 3> there{};
    there[other] = beta + gamma;
    there[(other + 1) % 3] = alpha + gamma;
    there[(other + 2) % 3] = -gamma;
    return TrianglePoint{root, there[1], there[2]};
}

TriangleSites::TriangleSites(const ControlMesh& mesh)
    : mesh_(&mesh), first_corner_(mesh.vertex_count(), HalfedgeId::none) {
    for (std::uint32_t h = mesh.halfedge_count(); h-- > 0;) first_corner_[mesh.origin(HalfedgeId(h)).value] = h;
}

Site TriangleSites::canonical(const Site& site) const {
    const Site reduced = minimal_level(site);
    if (reduced.level == 0) return vertex(mesh_->origin(corner_halfedge(reduced.root, corner_of(reduced.at))));
    const int side = side_of(reduced);
    return side < 0 ? reduced : canonical_on_side(*mesh_, reduced, side);
}

Site TriangleSites::vertex(VertexId v) const {
    const HalfedgeId first(first_corner_[v.value]);
    return first.valid() ? corner_site(*mesh_, first) : Site{};
}

Site canonical_triangle_site(const ControlMesh& mesh, const Site& site) {
    const Site reduced = minimal_level(site);
    if (reduced.level > 0) {
        const int side = side_of(reduced);
        return side < 0 ? reduced : canonical_on_side(mesh, reduced, side);
    }
    // A boundary vertex's fan is swept from the half-edge that has no twin, an interior one's from anywhere.
    const HalfedgeId start = mesh.vertex_halfedge(mesh.origin(corner_halfedge(reduced.root, corner_of(reduced.at))));
    HalfedgeId smallest = start;
    for (HalfedgeId h = mesh.ccw_outgoing(start); h.valid() && h != start; h = mesh.ccw_outgoing(h))
        smallest = std::min(smallest, h);
    return corner_site(mesh, smallest);
}

}  // namespace tetrakis
