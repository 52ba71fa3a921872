#include "loop_patches.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../refine/rules/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/loop.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

namespace tetrakis {

using detail::Bary;
using detail::corner_at;
using detail::CornerRing;
using detail::for_each_outgoing;
using detail::LoopCell;
using detail::LoopNode;
using detail::LoopRings;
using detail::LoopStarChain;
using detail::Net12;

namespace {

constexpr std::uint32_t k_none = HalfedgeId::none;
constexpr std::array<Vec2d, 3> k_corner_parameters{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};

/// Every way to a position ends here, so that all of them have the same bits.
Vec3d net_position(const Net12& net, const Bary& b) {
    const int corner = corner_at(b);
    return corner < 0 ? detail::box_spline_position(net, b) : detail::box_spline_corner(net, corner);
}

}  // namespace

LoopPatches::LoopPatches(const ControlMesh& mesh, const RunContext& context) : mesh_(mesh) {
    detail::refuse_corner_angles(mesh);
    if (!mesh.all_triangles())
        throw Error(ErrorCode::invalid_input,
                    "Loop subdivision needs triangles, but some faces have more corners; triangulate first");
    const std::uint64_t bytes = sizeof(Vec3d) * (2 * std::uint64_t{mesh.vertex_count()} + mesh.edge_count()) +
                                mesh.vertex_count() + mesh.face_count() +
                                std::uint64_t{mesh.halfedge_count()} * sizeof(Grown);
    if (context.max_memory_bytes != 0 && bytes > context.max_memory_bytes)
        throw Error(ErrorCode::memory_limit, "the patches of this mesh need " + std::to_string(bytes) +
                                                 " bytes, more than the limit of " +
                                                 std::to_string(context.max_memory_bytes));
    with_threads(context, [&] {
        first_step();
        classify_roots();
        corner_limits();
    });
}

LoopPatches::~LoopPatches() {
    for (std::uint32_t h = 0; h < grown_.size(); ++h)
        if (kind_[h / 3] == RootKind::generic) delete grown_[h].node.load(std::memory_order_relaxed);
}

std::uint64_t LoopPatches::memory_bytes() const {
    return sizeof(Vec3d) * (vertex_points_.size() + edge_points_.size() + limits_.size()) + smooth_.size() +
           kind_.size() + sizeof(Grown) * grown_.size();
}

/// The ring of origin(h) with the cell at h.
CornerRing LoopPatches::control_ring(std::uint32_t h) const {
    const VertexId v(origin(h));
    CornerRing ring;
    ring.centre = mesh_.position(v);
    ring.sharpness = mesh_.sharpness(v);
    ring.boundary = mesh_.is_boundary(v);
    ring.chaikin = mesh_.crease_method() == CreaseMethod::chaikin;
    std::uint32_t last = k_none;
    for_each_outgoing(mesh_, v, [&](HalfedgeId o) {
        if (o.value == h) ring.cell = ring.size();
        CornerRing::Spoke s;
        s.point = control(next(o.value));
        s.sharpness = mesh_.sharpness(mesh_.edge(o));
        if (is_sharp(s.sharpness)) s.far_half = twin(o.value) == k_none ? s.sharpness : half_sharpness(twin(o.value));
        ring.spokes.push_back(s);
        last = prev(o.value);
    });
    if (ring.boundary) ring.spokes.push_back({control(last), Vec3d(0), k_sharpness_infinity, 0, k_sharpness_infinity});
    ring.halve();
    return ring;
}

float LoopPatches::half_sharpness(std::uint32_t h) const {
    const float s = mesh_.sharpness(mesh_.edge(HalfedgeId(h)));
    if (mesh_.crease_method() != CreaseMethod::chaikin || !is_semi_sharp(s)) return child_sharpness(s);
    std::vector<float> around;  // infinite ones do not weigh in
    for_each_outgoing(mesh_, VertexId(origin(h)),
                      [&](HalfedgeId o) { around.push_back(mesh_.sharpness(mesh_.edge(o))); });
    return child_sharpness_chaikin(s, around);
}

void LoopPatches::first_step() {
    const std::uint32_t vertex_count = mesh_.vertex_count(), edge_count = mesh_.edge_count();
    vertex_points_.resize(vertex_count);
    smooth_.assign(vertex_count, 0);
    for_each_index(vertex_count, [&](std::uint32_t v) {
        const std::uint32_t start = mesh_.vertex_halfedge(VertexId(v)).value;
        if (start == k_none) return;
        const CornerRing ring = control_ring(start);
        smooth_[v] = ring.is_smooth();
        vertex_points_[v] = ring.vertex_point();
    });

    edge_points_.resize(edge_count);
    for_each_index(edge_count, [&](std::uint32_t e) {
        const std::uint32_t h = mesh_.edge_halfedge(EdgeId(e)).value, t = twin(h);
        const Vec3d ends = control(h) + control(next(h));
        if (t == k_none) {
            edge_points_[e] = 0.5 * ends;
            return;
        }
        edge_points_[e] = Loop::edge_end * ends + Loop::edge_opposite * (control(prev(h)) + control(prev(t)));
        const float s = mesh_.sharpness(EdgeId(e));
        if (!is_sharp(s)) return;
        const double crease = edge_crease_weight(s, half_sharpness(h), half_sharpness(t));
        if (crease != 0) edge_points_[e] = (1 - crease) * edge_points_[e] + (crease * 0.5) * ends;
    });
}

void LoopPatches::classify_roots() {
    kind_.resize(mesh_.face_count());
    grown_ = std::vector<Grown>(mesh_.halfedge_count());
    for_each_index(mesh_.face_count(), [&](std::uint32_t f) {
        int extraordinary = 0, which = 0;
        bool smooth = true;
        for (int k = 0; k < 3; ++k) {
            const VertexId v(origin(3 * f + k));
            smooth &= smooth_[v.value] != 0;
            if (mesh_.face_valence(v) != 6) {
                ++extraordinary;
                which = k;
            }
        }
        if (!smooth)
            kind_[f] = RootKind::generic;
        else if (extraordinary == 0)
            kind_[f] = RootKind::regular;
        else if (extraordinary == 1)
            kind_[f] = static_cast<RootKind>(static_cast<int>(RootKind::star0) + which);
        else
            kind_[f] = RootKind::split;
    });
}

/// Star (valence 6: Net12) around the triangle of h, origin(h) first, from control points; origin(h) is smooth, the
/// other two corners are smooth and regular.
void LoopPatches::gather_control(std::uint32_t h, int valence, Vec3d* out) const {
    *out++ = control(h);
    std::uint32_t o = h;
    for (int i = 0; i < valence; ++i) {
        *out++ = control(next(o));
        o = twin(prev(o));
    }
    // Around (1,0), counter-clockwise after (0,1), (0,0), (1,-1): (2,-1), (2,0), (1,1).
    o = twin(prev(twin(h)));
    for (int i = 0; i < 3; ++i) {
        o = twin(prev(o));
        *out++ = control(next(o));
    }
    // Around (0,1), after (0,0), (1,0), (1,1): (0,2), (-1,2).
    o = twin(prev(twin(next(h))));
    for (int i = 0; i < 2; ++i) {
        o = twin(prev(o));
        *out++ = control(next(o));
    }
}

/// The same one level further down, around the quarter at origin(h), which is smooth.
void LoopPatches::gather_first(std::uint32_t h, int valence, Vec3d* out) const {
    *out++ = vertex_point(h);
    std::uint32_t o = h;
    for (int i = 0; i < valence; ++i) {
        *out++ = edge_point(o);
        o = twin(prev(o));
    }
    *out++ = edge_point(prev(twin(h)));
    *out++ = vertex_point(next(h));
    *out++ = edge_point(next(h));
    *out++ = vertex_point(prev(h));
    *out++ = edge_point(next(twin(prev(h))));
}

void LoopPatches::gather_centre(std::uint32_t h, Net12& out) const {
    const std::uint32_t h1 = next(h), h2 = prev(h), t0 = twin(h), t1 = twin(h1), t2 = twin(h2);
    out[0] = edge_point(h1);
    out[1] = edge_point(h2);
    out[2] = edge_point(h);
    out[3] = vertex_point(h1);
    out[4] = edge_point(next(t1));
    out[5] = edge_point(prev(t1));
    out[6] = vertex_point(h2);
    out[7] = edge_point(next(t2));
    out[8] = edge_point(prev(t2));
    out[9] = vertex_point(h);
    out[10] = edge_point(next(t0));
    out[11] = edge_point(prev(t0));
}

const LoopStarChain& LoopPatches::star_root(std::uint32_t h, bool first_level) const {
    LoopStarChain* known = grown_[h].star.load(std::memory_order_acquire);
    if (known != nullptr) return *known;
    const int valence = static_cast<int>(mesh_.face_valence(VertexId(origin(h))));
    LoopStarChain& fresh = LoopStarChain::make(pool_, valence, detail::loop_star_size(valence));
    if (first_level)
        gather_first(h, valence, fresh.points());
    else
        gather_control(h, valence, fresh.points());
    return grown_[h].star.compare_exchange_strong(known, &fresh, std::memory_order_acq_rel) ? fresh : *known;
}

const LoopNode& LoopPatches::generic_root(std::uint32_t h) const {
    LoopNode* known = grown_[h].node.load(std::memory_order_acquire);
    if (known != nullptr) return *known;
    LoopRings rings{{control_ring(h), control_ring(h + 1), control_ring(h + 2)}};
    auto fresh = std::make_unique<LoopNode>(std::move(rings), pool_);
    if (grown_[h].node.compare_exchange_strong(known, fresh.get(), std::memory_order_acq_rel)) known = fresh.release();
    return *known;
}

void LoopPatches::root_cell(HalfedgeId root, LoopCell& out) const {
    const std::uint32_t h = root.value;
    const RootKind kind = kind_[h / 3];
    out.turn = 0;
    switch (kind) {
        case RootKind::generic:
            out = generic_root(h).cell();
            return;
        case RootKind::regular:
            out.kind = LoopCell::Kind::regular;
            gather_control(h, 6, out.net.data());
            return;
        case RootKind::split:
            out.kind = LoopCell::Kind::split;
            out.face = h / 3;
            return;
        default:
            out.kind = LoopCell::Kind::star;
            out.turn = static_cast<int>(kind) - static_cast<int>(RootKind::star0);
            out.star = &star_root(h + static_cast<std::uint32_t>(out.turn), false);
    }
}

void LoopPatches::child(const LoopCell& cell, int quarter, LoopCell& out) const {
    if (cell.kind == LoopCell::Kind::generic) {
        out = cell.node->child(quarter).cell();
        return;
    }
    if (cell.kind == LoopCell::Kind::star) {
        const LoopStarChain& step = cell.star->next();
        out.turn = 0;
        out.kind = quarter == 0 ? LoopCell::Kind::star : LoopCell::Kind::regular;
        if (quarter == 0)
            out.star = &step;
        else
            detail::loop_star_quarter(step.valence(), step.points(), quarter, out.net);
        return;
    }
    const std::uint32_t h = 3 * cell.face;
    out.kind = LoopCell::Kind::regular;
    if (quarter == 3) {
        out.turn = 0;
        gather_centre(h, out.net);
        return;
    }
    const std::uint32_t corner = h + static_cast<std::uint32_t>(quarter);
    out.turn = quarter;
    if (mesh_.face_valence(VertexId(origin(corner))) == 6) {
        gather_first(corner, 6, out.net.data());
    } else {
        out.kind = LoopCell::Kind::star;
        out.star = &star_root(corner, true);
    }
}

/// The way down from a cell to where a point can be evaluated.
struct LoopPatches::Descent {
    LoopCell cell;
    Bary at;          ///< in the cell's frame
    int corner = -1;  ///< of a cell that is not regular, if the point is there
    // The parameters' directions in the cell's frame: `scale` times those of the first one, with corners renumbered by
    // `turn`.
    double scale = 1;
    int turn = 0;
};

/// False where the point is a corner that stays irregular: down.corner of down.cell.
bool LoopPatches::descend(Descent& down) const {
    LoopCell& cell = down.cell;
    Bary& b = down.at;
    while (cell.kind != LoopCell::Kind::regular) {
        down.corner = corner_at(b);
        if (down.corner == 0 || (down.corner > 0 && cell.kind != LoopCell::Kind::star)) return false;
        const int quarter = detail::quarter_of(b);
        b = detail::in_quarter(b, quarter);
        down.scale *= quarter == 3 ? -2 : 2;
        child(cell, quarter, cell);
        b = detail::turned(b, cell.turn);
        down.turn = (down.turn + cell.turn) % 3;
    }
    return true;
}

Vec3d LoopPatches::position(const LoopCell& cell, const Bary& at) const {
    if (cell.kind == LoopCell::Kind::regular) return net_position(cell.net, at);
    Descent down{cell, at};
    return descend(down) ? net_position(down.cell.net, down.at) : corner(down.cell, down.corner);
}

Vec3d LoopPatches::corner(const LoopCell& cell, int corner) const {
    switch (cell.kind) {
        case LoopCell::Kind::regular:
            return detail::box_spline_corner(cell.net, corner);
        case LoopCell::Kind::star:
            return corner == 0 ? detail::loop_star_limit(cell.star->valence(), cell.star->points())
                               : detail::loop_star_corner(cell.star->valence(), cell.star->points(), corner);
        case LoopCell::Kind::split:
            return corner_limit(3 * cell.face + static_cast<std::uint32_t>(corner));
        default:
            return cell.node->rings().corner[static_cast<std::size_t>(corner)].limit().position;
    }
}

void LoopPatches::corner_limits() {
    limits_.resize(mesh_.vertex_count());
    for_each_index(mesh_.vertex_count(), [&](std::uint32_t v) {
        if (mesh_.vertex_halfedge(VertexId(v)).valid()) limits_[v] = vertex_limit(VertexId(v));
    });
}

/// The ring is taken from the same half-edge for every root.
Vec3d LoopPatches::vertex_limit(VertexId v) const {
    const std::uint32_t start = mesh_.vertex_halfedge(v).value;
    if (!smooth_[v.value]) return control_ring(start).limit().position;
    Vec3d sum(0);
    int n = 0;
    detail::for_each_outgoing(mesh_, v, [&](HalfedgeId o) { sum += control(next(o.value)), ++n; });
    const RingMask mask = detail::loop_vertex_rule(n).limit;
    return mask.vertex * mesh_.position(v) + mask.edge * sum;
}

/// The surface at origin(h), seen from the root of h.
SurfacePoint LoopPatches::control_corner(std::uint32_t h) const {
    SurfacePoint out = control_ring(h).limit();
    out.position = limits_[origin(h)];
    return out;
}

Vec3d LoopPatches::limit(HalfedgeId root, LatticePoint at, int level) const {
    const double step = std::ldexp(1.0, -level);
    return position(root, at.x * step, at.y * step);
}

void LoopPatches::limits(std::span<const Site> sites, std::span<Vec3d> out) const {
    for (std::size_t i = 0; i < sites.size(); ++i) out[i] = limit(sites[i].root, sites[i].at, sites[i].level);
}

/// Of a corner inside a root: those of the root itself are control_corner()'s.
SurfacePoint LoopPatches::corner_point(const Descent& down) const {
    if (down.cell.kind == LoopCell::Kind::generic)
        return down.cell.node->rings().corner[static_cast<std::size_t>(down.corner)].limit();
    const LoopStarChain& star = *down.cell.star;
    SurfacePoint out = CornerRing::smooth(SchemeKind::loop, star.valence(), star.points()).limit();
    out.position = corner(down.cell, down.corner);  // the same bits as position()
    return out;
}

SurfacePoint LoopPatches::evaluate(HalfedgeId root, double x, double y, bool second) const {
    const Bary b{1 - x - y, x, y};
    if (const int at = corner_at(b); at >= 0) return control_corner(root.value + static_cast<std::uint32_t>(at));
    Descent down;
    root_cell(root, down.cell);
    down.at = detail::turned(b, down.cell.turn);
    down.turn = down.cell.turn;
    if (!descend(down)) return corner_point(down);
    // Derivatives by the root's x and y as combinations of those by the cell's: the root's coordinates grow by
    // (-1, 1, 0) along x and (-1, 0, 1) along y.
    constexpr std::array<double, 3> along_x{-1, 1, 0}, along_y{-1, 0, 1};
    const auto k1 = static_cast<std::size_t>((1 + down.turn) % 3), k2 = static_cast<std::size_t>((2 + down.turn) % 3);
    const double xx = down.scale * along_x[k1], xy = down.scale * along_x[k2], yx = down.scale * along_y[k1],
                 yy = down.scale * along_y[k2];
    const detail::BoxSplineTangents t = detail::box_spline_tangents(down.cell.net, down.at);
    SurfacePoint out;
    out.position = net_position(down.cell.net, down.at);
    out.du = xx * t.dx + xy * t.dy;
    out.dv = yx * t.dx + yy * t.dy;
    out.has_second = second;
    out.normal = unit_or_zero(glm::cross(out.du, out.dv));
    if (!second) return out;
    const detail::BoxSplineBends p = detail::box_spline_bends(down.cell.net, down.at);
    out.duu = xx * xx * p.dxx + 2 * xx * xy * p.dxy + xy * xy * p.dyy;
    out.duv = xx * yx * p.dxx + (xx * yy + xy * yx) * p.dxy + xy * yy * p.dyy;
    out.dvv = yx * yx * p.dxx + 2 * yx * yy * p.dxy + yy * yy * p.dyy;
    return out;
}

Vec3d LoopPatches::position(HalfedgeId root, double x, double y) const {
    const Bary b{1 - x - y, x, y};
    if (const int at = corner_at(b); at >= 0) return corner_limit(root.value + static_cast<std::uint32_t>(at));
    LoopCell cell;
    root_cell(root, cell);
    return position(cell, detail::turned(b, cell.turn));
}

SurfacePoint LoopPatches::vertex(HalfedgeId root, LatticePoint at, int level) const {
    const double scale = 1.0 / (std::uint32_t{1} << level);
    SurfacePoint out = frame(root, at.x * scale, at.y * scale);
    // On side s of the root, at parameter t along it?
    const std::uint32_t side = std::uint32_t{1} << level, z = side - at.x - at.y;
    const std::array<std::uint32_t, 3> b{z, at.x, at.y};
    for (std::uint32_t s = 0; s < 3; ++s) {
        if (b[(s + 2) % 3] != 0 || b[s] == 0 || b[(s + 1) % 3] == 0) continue;
        const std::uint32_t h = root.value + s, t = twin(h);
        if (t == HalfedgeId::none || mesh_.sharpness(mesh_.edge(HalfedgeId(h))) != k_sharpness_infinity) continue;
        const Vec2d from = k_corner_parameters[t % 3], to = k_corner_parameters[(t + 1) % 3];
        const Vec2d there = from + (b[s] * scale) * (to - from);
        const SurfacePoint other = frame(HalfedgeId(t - t % 3), there.x, there.y);
        out.normal = unit_or_zero(out.normal + other.normal);
    }
    return out;
}

}  // namespace tetrakis
