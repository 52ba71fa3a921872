#include "quad_patches.hpp"

#include "../../refine/rules/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrakis {

using detail::CornerRing;
using detail::for_each_outgoing;
using detail::QuadNode;

namespace {

/// What the rings of the largest face or vertex take: each of its corner cells keeps all of its own.
std::uint64_t ring_bytes(const ControlMesh& mesh) {
    std::uint64_t bytes = 0;
    const auto add = [&](std::uint64_t n) {
        bytes = std::max(bytes, n * detail::QuadStar::point_count(static_cast<int>(n)) * sizeof(Vec3d));
    };
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) add(mesh.face_size(FaceId(f)));
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
        if (!mesh.is_isolated(VertexId(v))) add(mesh.face_valence(VertexId(v)));
    return bytes;
}

const ControlMesh& checked(const ControlMesh& mesh, const RunContext& context) {
    detail::refuse_corner_angles(mesh);
    // Beside the trees: a pointer for each half-edge, two points for each edge or so.
    constexpr std::uint64_t k_of_root = sizeof(QuadNode*) + sizeof(Vec3d);
    detail::check_memory("the patch trees need", mesh.halfedge_count() * k_of_root + ring_bytes(mesh),
                         context.max_memory_bytes,
                         "cut up faces of very many corners and vertices of very many edges, or raise the limit");
    return mesh;
}

}  // namespace

QuadPatches::QuadPatches(const ControlMesh& mesh, const RunContext& context) : PatchTree(checked(mesh, context)) {
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
        const CornerRing ring = detail::control_ring(m, SchemeKind::catmull_clark, m.vertex_halfedge(v), face_points());
        first_[i] = ring.vertex_point();
        smooth_[i] = !ring.boundary && child_sharpness(ring.sharpness) == 0 &&
                     std::ranges::all_of(ring.spokes, [](const CornerRing::Spoke& s) { return s.near_half == 0; });
    });

    for_each_index(edges, [&](std::uint32_t e) {
        const HalfedgeId h = m.edge_halfedge(EdgeId(e)), t = m.twin(h);
        const Vec3d a = m.position(m.origin(h)), b = m.position(m.target(h));
        const Vec3d crease = 0.5 * (a + b);
        const float s = m.sharpness(EdgeId(e));
        if (!t.valid() || s == k_sharpness_infinity) {
            edge_points[e] = crease;
            return;
        }
        const Vec3d smooth = 0.25 * (a + b + face_point(h) + face_point(t));
        const double w = s == 0 ? 0 : edge_crease_weight(s, detail::half_sharpness(m, h), detail::half_sharpness(m, t));
        edge_points[e] = w == 0 ? smooth : w * crease + (1 - w) * smooth;
    });
}

void QuadPatches::gather_star(HalfedgeId h, detail::QuadStar& star) const {
    const ControlMesh& m = mesh_;
    const std::uint32_t n = m.face_valence(m.origin(h)), k = m.face_size(m.face(h));
    star.resize(static_cast<int>(n), static_cast<int>(k));
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
    auto star = std::make_unique_for_overwrite<detail::QuadStar>();
    gather_star(h, *star);
    if (star->regular()) {
        node.patch.net = star->net(0);
        return;
    }
    star->find_limit();
    node.become(std::move(star), 0);
}

/// Rings of level 1.
detail::CellRings<4> QuadPatches::root_rings(HalfedgeId root) const {
    const ControlMesh& m = mesh_;
    const auto ring = [&](HalfedgeId h) {
        return detail::control_ring(m, SchemeKind::catmull_clark, h, face_points());
    };
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

namespace {
bool is_hard(const ControlMesh& mesh, HalfedgeId h) {
    return mesh.twin(h).valid() && mesh.sharpness(mesh.edge(h)) == k_sharpness_infinity;
}
}  // namespace

SurfacePoint QuadPatches::vertex(HalfedgeId root, LatticePoint at, int level) const {
    const double step = std::ldexp(1.0, -level);
    SurfacePoint point = frame(root, at.x * step, at.y * step);
    const ControlMesh& m = mesh_;
    const auto normal_at = [&](HalfedgeId h, std::uint32_t x, std::uint32_t y) {
        return frame(h, x * step, y * step).normal;
    };
    Vec3d sum(0);
    if (at.x == 0 && at.y == 0) {
        // A control vertex with hard edges: the mean over its corner cells.
        bool hard = false;
        for_each_outgoing(m, m.origin(root), [&](HalfedgeId h) { hard |= is_hard(m, h); });
        if (!hard) return point;
        for_each_outgoing(m, m.origin(root), [&](HalfedgeId h) { sum += normal_at(h, 0, 0); });
    } else if (at.y == 0 && is_hard(m, root)) {
        sum = point.normal + normal_at(m.cw_outgoing(root), 0, at.x);
    } else if (at.x == 0 && is_hard(m, m.prev(root))) {
        sum = point.normal + normal_at(m.ccw_outgoing(root), at.y, 0);
    } else {
        return point;
    }
    const double length = glm::length(sum);
    if (length > 0) point.normal = sum / length;
    return point;
}

}  // namespace tetrakis
