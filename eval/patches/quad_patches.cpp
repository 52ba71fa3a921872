#include "quad_patches.hpp"

#include "../../refine/rules/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis {

namespace detail {

OuterPoints QuadShape::beyond(const CornerRing& ring) {
    const Vec3d& c = ring.centre;
    const auto e = [&](int i) { return ring.spoke(ring.cell + i).point; };
    const auto f = [&](int i) { return ring.spoke(ring.cell + i).face; };
    const auto sharpness = [&](int i) { return ring.spoke(ring.cell + i).sharpness; };
    if (ring.is_smooth()) {
        OuterPoints out;
        for (int i = 2; i < ring.size(); ++i) {
            out.push_back(e(i));
            if (i + 1 < ring.size()) out.push_back(f(i));
        }
        return out;
    }
    if (!ring.is_stationary()) {
        if (ring.boundary || ring.size() != 4 || ring.sharpness != 0) return {};
        const int along = is_sharp(sharpness(0)) ? 0 : 1;
        // With Chaikin's method an edge's halves, and so all later levels, depend on adjacent edges.
        const auto even = [&](int i) {
            const CornerRing::Spoke& s = ring.spoke(ring.cell + i);
            return !ring.chaikin || s.near_half == s.far_half;
        };
        const bool straight = sharpness(along) == sharpness(along + 2) && even(along) && even(along + 2) &&
                              sharpness(along + 1) == 0 && sharpness(along + 3) == 0;
        if (!straight) return {};
        return {e(2), f(2), e(3)};
    }
    const auto sector = ring.sector();
    if (!sector || sector->faces != (sector->corner ? 1 : 2)) return {};
    if (sector->corner) return {2.0 * c - e(0), 4.0 * c - 2.0 * (e(0) + e(1)) + f(0), 2.0 * c - e(1)};
    if (sector->first == ring.cell) return {e(2), 2.0 * e(2) - f(1), 2.0 * c - e(1)};
    return {2.0 * c - e(0), 2.0 * e(-1) - f(-1), e(-1)};
}

SurfacePoint QuadShape::evaluate(const Patch& patch, const Vec2d& at, bool second) {
    const auto derivative = [&](int by_x, int by_y) {
        return combine(patch.net, regular_basis(patch.crease, 0, at.x, by_x),
                       regular_basis(patch.crease, 1, at.y, by_y));
    };
    SurfacePoint point{derivative(0, 0), derivative(1, 0), derivative(0, 1)};
    if (second) point.duu = derivative(2, 0), point.duv = derivative(1, 1), point.dvv = derivative(0, 2);
    return point;
}

}  // namespace detail

using detail::CornerRing;
using detail::for_each_outgoing;
using detail::QuadNode;

namespace {

/// Bytes of the rings around the largest face or vertex: each corner cell there keeps a ring of its own.
std::uint64_t ring_bytes(const ControlMesh& mesh) {
    std::uint64_t bytes = 0;
    const auto add = [&](std::uint64_t n) { bytes = std::max(bytes, n * 2 * (n + 4) * sizeof(Vec3d)); };
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) add(mesh.face_size(FaceId(f)));
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        if (!mesh.is_isolated(VertexId(v))) add(mesh.face_valence(VertexId(v)));
    return bytes;
}

const ControlMesh& checked(const ControlMesh& mesh, const RunContext& context) {
    detail::refuse_corner_angles(mesh);
    // Besides the trees: a pointer for each half-edge, and about two points for each edge.
    constexpr std::uint64_t k_of_root = sizeof(QuadNode*) + sizeof(Vec3d);
    detail::check_memory("the patch trees need", mesh.halfedge_count() * k_of_root + ring_bytes(mesh),
                         context.max_memory_bytes,
                         "cut up faces of very many corners and vertices of very many edges, or raise the limit");
    return mesh;
}

}  // namespace

QuadPatches::QuadPatches(const ControlMesh& mesh, const RunContext& context)
    : PatchTree(checked(mesh, context), context) {
    first_step();
}

std::uint64_t QuadPatches::memory_bytes() const {
    return PatchTree::memory_bytes() + first_.size() * sizeof(Vec3d) + smooth_.size();
}

void QuadPatches::first_step() {
    const ControlMesh& m = mesh_;
    const std::uint32_t vertices = m.vertex_count(), edges = m.edge_count(), faces = m.face_count();
    first_.resize(std::size_t{vertices} + edges + faces);
    smooth_.assign(vertices, 0);
    Vec3d* edge_points = first_.data() + vertices;
    Vec3d* of_faces = edge_points + edges;

    for_each_index(faces, [&](std::uint32_t f) {
        Vec3d sum(0);
        const std::uint32_t size = m.face_size(FaceId(f)), h0 = m.face_halfedge(FaceId(f)).value;
        for (std::uint32_t i = 0; i < size; ++i) sum += m.position(m.origin(HalfedgeId(h0 + i)));
        of_faces[f] = sum / static_cast<double>(size);
    });

    for_each_index(vertices, [&](std::uint32_t i) {
        const VertexId v(i);
        first_[i] = m.position(v);
        if (m.is_isolated(v)) return;
        const CornerRing here = ring(m.vertex_halfedge(v));
        first_[i] = here.vertex_point();
        smooth_[i] = !here.boundary && child_sharpness(here.sharpness) == 0 &&
                     std::ranges::all_of(here.spokes, [](const CornerRing::Spoke& s) { return s.near_half == 0; });
        int spoke = 0;
        for_each_outgoing(m, v, [&](HalfedgeId h) {
            if (m.edge_halfedge(m.edge(h)) == h) edge_points[m.edge(h).value] = here.edge_point(spoke);
            ++spoke;
        });
    });
}

void QuadPatches::gather_star(HalfedgeId h, detail::QuadStar& star) const {
    const ControlMesh& m = mesh_;
    const std::uint32_t n = m.face_valence(m.origin(h)), k = m.face_size(m.face(h));
    star.resize({static_cast<int>(n), 4, static_cast<int>(k), 4});
    Vec3d* out = star.points.data();
    *out++ = vertex_point(m.origin(h));
    HalfedgeId g = h;
    for (std::uint32_t i = 0; i < n; ++i, g = m.ccw_outgoing(g)) *out++ = edge_point(g), *out++ = face_point(g);
    *out++ = edge_point(m.prev(m.twin(h)));
    g = m.next(h);
    *out++ = vertex_point(m.origin(g));
    for (std::uint32_t i = 2; i < k; ++i) *out++ = edge_point(g), g = m.next(g), *out++ = vertex_point(m.origin(g));
    *out = edge_point(m.next(m.twin(m.prev(h))));
}

void QuadPatches::build_root(HalfedgeId h, QuadNode& node) const {
    const ControlMesh& m = mesh_;
    const HalfedgeId before = m.prev(h), t = m.twin(h);
    const bool smooth = smooth_[m.origin(h).value] && m.face_valence(m.origin(h)) > 2 && t.valid() &&
                        m.twin(before).valid() && detail::half_sharpness(m, t) == 0 &&
                        detail::half_sharpness(m, before) == 0;
    if (!smooth) return node.become(root_rings(h));
    detail::QuadStar star;
    gather_star(h, star);
    node.become(std::move(star), 0);
}

/// The rings of a root's corners, at level 1.
detail::CellRings<4> QuadPatches::root_rings(HalfedgeId root) const {
    const ControlMesh& m = mesh_;
    const CornerRing here = ring(root), after = ring(m.next(root)), before = ring(m.prev(root)), child = here.child();
    CornerRing centre;
    centre.scheme = SchemeKind::catmull_clark;
    centre.chaikin = here.chaikin;
    centre.centre = face_point(root);
    HalfedgeId h = root;
    do {
        centre.spokes.push_back({edge_point(h), vertex_point(m.target(h))});
        h = m.next(h);
    } while (h != root);
    centre.cell = centre.size() - 1;
    detail::CellRings<4> rings{
        {child, side_ring(here, after, child, after.child()), centre, side_ring(before, here, before.child(), child)}};
    rings.corner[1].cell = 1;
    return rings;
}

}  // namespace tetrakis
