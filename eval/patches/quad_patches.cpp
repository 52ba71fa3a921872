#include "quad_patches.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../refine/rules/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <string>

namespace tetrakis {

using detail::CornerRing;
using detail::for_each_outgoing;
using detail::Net16;
using detail::QuadNode;
using detail::QuadRoot;
using detail::Weights4;

namespace {
/// Below this a cell is a point: parameters have no more bits.
constexpr int k_deepest_cell = 52;

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
}  // namespace

QuadPatches::QuadPatches(const ControlMesh& mesh, const RunContext& context) : mesh_(mesh) {
    detail::refuse_corner_angles(mesh);
    // Beside the trees: a pointer and a sharpness for each half-edge, two points for each edge or so.
    constexpr std::uint64_t k_of_root = sizeof(QuadRoot*) + sizeof(float) + sizeof(Vec3d);
    const std::uint64_t bytes = mesh.halfedge_count() * k_of_root + ring_bytes(mesh);
    if (context.max_memory_bytes != 0 && bytes > context.max_memory_bytes)
        throw Error(ErrorCode::memory_limit,
                    "the patch tree of " + std::to_string(mesh.halfedge_count()) + " corner cells needs " +
                        std::to_string(bytes) + " bytes, more than the limit of " +
                        std::to_string(context.max_memory_bytes) +
                        "; cut up faces of very many corners and vertices of very many edges, or raise the limit");
    first_step();
    roots_ = decltype(roots_)(mesh.halfedge_count());
}

QuadPatches::~QuadPatches() { forget_trees(); }

std::uint64_t QuadPatches::memory_bytes() const {
    return roots_.size() * sizeof(roots_[0]) + first_.size() * sizeof(Vec3d) +
           (half_sharpness_.size() + vertex_sharpness_.size()) * sizeof(float) + smooth_.size() + forgettable_bytes();
}

std::uint64_t QuadPatches::bytes_to_keep() const {
    constexpr std::uint64_t k_least = 16 << 20, k_of_root = 256;
    return std::max(k_least, k_of_root * roots_.size());
}

const QuadNode& QuadPatches::made_root(HalfedgeId root) const {
    auto fresh = std::make_unique<QuadRoot>();
    fresh->bytes = &tree_bytes_;
    build_root(root, *fresh);
    QuadRoot* known = nullptr;
    if (!roots_[root.value].compare_exchange_strong(known, fresh.get(), std::memory_order_acq_rel)) return *known;
    tree_bytes_.fetch_add(sizeof(QuadRoot) + fresh->own_bytes(), std::memory_order_relaxed);
    return *fresh.release();
}

void QuadPatches::forget_tree(HalfedgeId root) const {
    const std::unique_ptr<QuadRoot> tree(roots_[root.value].exchange(nullptr, std::memory_order_acquire));
    if (!tree) return;
    tree_bytes_.fetch_sub(sizeof(QuadRoot) + tree->grown_bytes(), std::memory_order_relaxed);
    times_forgotten_.fetch_add(1, std::memory_order_relaxed);
}

void QuadPatches::forget_trees() const {
    for_each_index(
        static_cast<std::uint32_t>(roots_.size()),
        [&](std::uint32_t root) { delete roots_[root].exchange(nullptr, std::memory_order_acquire); }, 1024);
    tree_bytes_.store(0, std::memory_order_relaxed);
    times_forgotten_.fetch_add(1, std::memory_order_relaxed);
}

void QuadPatches::first_step() {
    const ControlMesh& m = mesh_;
    const std::uint32_t vertices = m.vertex_count(), edges = m.edge_count(), faces = m.face_count();
    first_.resize(std::size_t{vertices} + edges + faces);
    half_sharpness_.assign(m.halfedge_count(), 0.0f);
    vertex_sharpness_.assign(vertices, 0.0f);
    smooth_.assign(vertices, 0);
    Vec3d* edge_points = first_.data() + vertices;
    Vec3d* face_points = edge_points + edges;
    const bool chaikin = m.crease_method() == CreaseMethod::chaikin;

    for_each_index(faces, [&](std::uint32_t f) {
        Vec3d sum(0);
        const std::uint32_t size = m.face_size(FaceId(f)), h0 = m.face_halfedge(FaceId(f)).value;
        for (std::uint32_t i = 0; i < size; ++i) sum += m.position(m.origin(HalfedgeId(h0 + i)));
        face_points[f] = sum / static_cast<double>(size);
    });

    // Vertices: the tags of the halves at each vertex, and the vertex points.
    for_each_index(vertices, [&](std::uint32_t i) {
        const VertexId v(i);
        first_[i] = m.position(v);
        if (m.is_isolated(v)) return;
        CornerRing ring{SchemeKind::catmull_clark, m.position(v), m.sharpness(v), m.is_boundary(v), chaikin, 0, {}};
        HalfedgeId last;
        for_each_outgoing(m, v, [&](HalfedgeId h) {
            ring.spokes.push_back({m.position(m.target(h)), face_points[m.face(h).value], m.sharpness(m.edge(h))});
            last = m.prev(h);
        });
        if (ring.boundary) ring.spokes.push_back({m.position(m.origin(last)), Vec3d(0), m.sharpness(m.edge(last))});
        // The far corners of quads that have the faces' own points.
        for (int j = 0; j < ring.faces(); ++j) {
            CornerRing::Spoke& s = ring.spokes[static_cast<std::size_t>(j)];
            s.face = 4.0 * s.face - (ring.centre + s.point + ring.spoke(j + 1).point);
        }
        ring.halve();
        first_[i] = ring.vertex_point();
        vertex_sharpness_[i] = child_sharpness(m.sharpness(v));
        bool smooth = !ring.boundary && vertex_sharpness_[i] == 0;
        std::size_t j = 0;
        for_each_outgoing(m, v, [&](HalfedgeId h) {
            half_sharpness_[h.value] = ring.spokes[j++].near_half;
            smooth &= half_sharpness_[h.value] == 0;
        });
        smooth_[i] = smooth;
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
        const Vec3d smooth = 0.25 * (a + b + face_points[m.face(h).value] + face_points[m.face(t).value]);
        const double w = s == 0 ? 0 : edge_crease_weight(s, half_sharpness_[h.value], half_sharpness_[t.value]);
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
    const bool smooth = smooth_[m.origin(h).value] && t.valid() && m.twin(before).valid() &&
                        half_sharpness_[t.value] == 0 && half_sharpness_[before.value] == 0;
    if (!smooth) return detail::classify(root_rings(h), node);
    detail::QuadStar star;
    gather_star(h, star);
    if (star.regular()) return star.put(node.net);
    star.find_limit();
    node.adopt(std::make_unique<detail::QuadStar>(std::move(star)), 0);
}

/// Rings of level 1.
detail::QuadRings QuadPatches::root_rings(HalfedgeId root) const {
    using Spoke = CornerRing::Spoke;
    const ControlMesh& m = mesh_;
    const bool chaikin = m.crease_method() == CreaseMethod::chaikin;
    const auto fresh = [&](const Vec3d& centre) {
        CornerRing ring;
        ring.scheme = SchemeKind::catmull_clark;
        ring.centre = centre;
        ring.chaikin = chaikin;
        return ring;
    };
    // Of the half at the origin of a half-edge.
    const auto sharpness = [&](HalfedgeId h) {
        return m.twin(h).valid() ? half_sharpness_[h.value] : k_sharpness_infinity;
    };
    const auto vertex_ring = [&](HalfedgeId h) {
        const VertexId v = m.origin(h);
        CornerRing ring = fresh(vertex_point(v));
        ring.sharpness = vertex_sharpness_[v.value];
        ring.boundary = m.is_boundary(v);
        HalfedgeId last;
        for_each_outgoing(m, v, [&](HalfedgeId o) {
            if (o == h) ring.cell = ring.size();
            Spoke s{edge_point(o), face_point(o), sharpness(o)};
            // At the edge's middle only its two halves can be sharp.
            s.far_half = chaikin && m.twin(o).valid()
                             ? child_sharpness_chaikin(s.sharpness, std::array{s.sharpness, sharpness(m.twin(o))})
                             : child_sharpness(s.sharpness);
            ring.spokes.push_back(s);
            last = m.prev(o);
        });
        if (ring.boundary) {
            ring.spokes.push_back({edge_point(last), Vec3d(0), k_sharpness_infinity, 0, k_sharpness_infinity});
        }
        ring.halve();
        return ring;
    };
    // Spoke 0 leads to the edge's target, spoke 1 into the face.
    const auto edge_ring = [&](HalfedgeId h) {
        CornerRing ring = fresh(edge_point(h));
        const HalfedgeId t = m.twin(h);
        ring.boundary = !t.valid();
        // Towards a vertex, along the half-edge that leaves it.
        const auto add_half = [&](VertexId v, HalfedgeId o, const Vec3d& face) {
            Spoke s{vertex_point(v), face, o.valid() ? sharpness(o) : k_sharpness_infinity};
            s.far_half = child_sharpness(s.sharpness);
            if (chaikin && is_semi_sharp(s.sharpness)) {
                const CornerRing at_end = vertex_ring(o);
                s.far_half = at_end.spoke(at_end.cell).near_half;
            }
            ring.spokes.push_back(s);
        };
        add_half(m.target(h), t, edge_point(m.next(h)));
        ring.spokes.push_back({face_point(h), edge_point(m.prev(h))});
        add_half(m.origin(h), h, t.valid() ? edge_point(m.next(t)) : Vec3d(0));
        if (t.valid()) ring.spokes.push_back({face_point(t), edge_point(m.prev(t))});
        ring.halve();
        return ring;
    };
    detail::QuadRings rings{{vertex_ring(root), edge_ring(root), fresh(face_point(root)), edge_ring(m.prev(root))}};
    rings.corner[1].cell = 1;
    CornerRing& centre = rings.corner[2];
    HalfedgeId h = root;
    do {
        centre.spokes.push_back({edge_point(h), vertex_point(m.target(h))});
        h = m.next(h);
    } while (h != root);
    centre.cell = centre.size() - 1;
    return rings;
}

SurfacePoint QuadPatches::corner_limit(const QuadNode& node, int corner) {
    assert(node.kind != QuadNode::Kind::regular);
    if (node.kind == QuadNode::Kind::generic) return node.rings->corner[static_cast<std::size_t>(corner)].limit();
    return CornerRing::smooth(SchemeKind::catmull_clark, node.star->valence, node.star->points.data()).limit();
}

Vec3d QuadPatches::limit(HalfedgeId root, LatticePoint at, int level) const {
    const double step = std::ldexp(1.0, -level);
    return position(root_node(root), at.x * step, at.y * step);
}

void QuadPatches::limits(std::span<const Site> sites, std::span<Vec3d> out) const {
    for (std::size_t i = 0; i < sites.size(); ++i) out[i] = limit(sites[i].root, sites[i].at, sites[i].level);
}

namespace {
/// The corner of an irregular cell that (x, y) is, or is as good as; -1: none.
int corner_at(const QuadNode& node, double x, double y) {
    const bool is_corner = (x == 0 || x == 1) && (y == 0 || y == 1);
    if (!is_corner && node.depth <= k_deepest_cell) return -1;
    return y < 0.5 ? (x < 0.5 ? 0 : 1) : (x < 0.5 ? 3 : 2);
}
}  // namespace

Vec3d QuadPatches::position(const QuadNode& cell, double x, double y) {
    const QuadNode* node = &cell;
    while (node->kind != QuadNode::Kind::regular) {
        if (const int corner = corner_at(*node, x, y); corner >= 0) return node->corner(corner);
        const int qx = x >= 0.5, qy = y >= 0.5;
        x = 2 * x - qx, y = 2 * y - qy;
        node = node->grown() + 2 * qy + qx;
    }
    return regular_position(node->net, node->crease, x, y);
}

SurfacePoint QuadPatches::evaluate(HalfedgeId root, double x, double y, bool second) const {
    const QuadNode* node = &root_node(root);
    std::optional<Vec3d> kept;  // the same bits as position()
    double scale = 1;
    while (node->kind != QuadNode::Kind::regular) {
        if (const int corner = corner_at(*node, x, y); corner >= 0) {
            if (!kept) kept = node->corner(corner);
            if (node->kind == QuadNode::Kind::generic || corner == node->turn) {
                SurfacePoint point = corner_limit(*node, corner);
                point.position = *kept;
                return point;
            }
        }
        const int qx = x >= 0.5, qy = y >= 0.5;
        x = 2 * x - qx, y = 2 * y - qy;
        scale *= 2;
        node = node->grown() + 2 * qy + qx;
    }
    Weights4 wx[3], wy[3];
    regular_basis(node->crease, x, y, wx, wy);
    SurfacePoint point;
    const detail::NetTangents tangents = detail::combine_tangents(node->net, wx, wy);
    point.position = kept ? *kept : tangents.position;
    point.du = scale * tangents.du;
    point.dv = scale * tangents.dv;
    point.has_second = second;
    point.normal = unit_or_zero(glm::cross(point.du, point.dv));
    if (!second) return point;
    point.duu = scale * scale * combine(node->net, wx[2], wy[0]);
    point.duv = scale * scale * combine(node->net, wx[1], wy[1]);
    point.dvv = scale * scale * combine(node->net, wx[0], wy[2]);
    return point;
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
