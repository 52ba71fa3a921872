#include "tetrakis/eval/loop_patches.hpp"

#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/schemes/loop.hpp"
#include "tetrakis/schemes/ring_limit.hpp"
#include "tetrakis/schemes/sharpness.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tetrakis {

using detail::Bary;
using detail::LoopCell;
using detail::LoopNode;
using detail::LoopRing;
using detail::LoopRings;
using detail::LoopStarChain;
using detail::Net12;

namespace {

constexpr std::uint32_t k_none = HalfedgeId::none;
constexpr std::array<Vec2d, 3> k_corner_parameters{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};

/// An interior smooth extraordinary point: the tangents are the ring's cosine and sine sums, the cosine along x.
SurfacePoint star_corner(const LoopStarChain& star) {
    const RingLimit& limit = smooth_ring_limit(SchemeKind::loop, star.valence());
    const std::span<const Vec3d> ring(star.points(), static_cast<std::size_t>(star.valence()) + 1);
    SurfacePoint out;
    out.position = detail::loop_star_limit(star.valence(), star.points());
    for (std::size_t i = 0; i < ring.size(); ++i) {
        out.du += limit.tangent1[i] * ring[i];
        out.dv += limit.tangent2[i] * ring[i];
    }
    out.has_second = out.has_derivatives = false;
    const RingShape shape{.faces = star.valence()};
    out.normal = limit_normal(SchemeKind::loop, shape, limit, ring);
    return out;
}

Vec3d unit_or_zero(const Vec3d& v) {
    const double length = glm::length(v);
    return length > 0 ? v / length : Vec3d(0);
}

}  // namespace

LoopPatches::LoopPatches(const ControlMesh& mesh, const RunContext& context) : mesh_(mesh) {
    if (!mesh.all_triangles())
        throw Error(ErrorCode::invalid_input,
                    "Loop subdivision needs triangles, but some faces have more corners; triangulate first");
    const std::uint64_t bytes = sizeof(Vec3d) * (std::uint64_t{mesh.vertex_count()} + mesh.edge_count()) +
                                mesh.vertex_count() + mesh.face_count() +
                                std::uint64_t{mesh.halfedge_count()} * (sizeof(Grown) + sizeof(float));
    if (context.max_memory_bytes != 0 && bytes > context.max_memory_bytes)
        throw Error(ErrorCode::memory_limit, "the patches of this mesh need " + std::to_string(bytes) +
                                                 " bytes, more than the limit of " +
                                                 std::to_string(context.max_memory_bytes));
    with_threads(context, [&] {
        first_step(context);
        classify_roots();
    });
}

LoopPatches::~LoopPatches() {
    for (std::uint32_t h = 0; h < grown_.size(); ++h) {
        if (kind_[h / 3] == RootKind::generic)
            delete grown_[h].node.load(std::memory_order_relaxed);
        else
            delete grown_[h].star.load(std::memory_order_relaxed);
    }
}

std::uint64_t LoopPatches::memory_bytes() const {
    return sizeof(Vec3d) * (vertex_points_.size() + edge_points_.size()) + sizeof(float) * half_sharpness_.size() +
           smooth_.size() + kind_.size() + sizeof(Grown) * grown_.size();
}

std::uint32_t LoopPatches::outgoing(VertexId v, std::uint32_t h, std::vector<std::uint32_t>& fan) const {
    fan.clear();
    std::uint32_t at = 0;
    const std::uint32_t start = mesh_.vertex_halfedge(v).value;
    for (std::uint32_t o = start;;) {
        if (o == h) at = static_cast<std::uint32_t>(fan.size());
        fan.push_back(o);
        o = twin(prev(o));
        if (o == k_none || o == start) return at;
    }
}

/// The ring of origin(h) with the cell at h. Halves come from half_sharpness_.
LoopRing LoopPatches::control_ring(std::uint32_t h) const {
    const VertexId v(origin(h));
    std::vector<std::uint32_t> fan;
    LoopRing ring;
    ring.cell = static_cast<int>(outgoing(v, h, fan));
    ring.centre = mesh_.position(v);
    ring.sharpness = mesh_.sharpness(v);
    ring.boundary = mesh_.is_boundary(v);
    ring.chaikin = mesh_.crease_method() == CreaseMethod::chaikin;
    for (const std::uint32_t o : fan) {
        LoopRing::Spoke s;
        s.point = control(next(o));
        if (!half_sharpness_.empty()) {
            s.sharpness = mesh_.sharpness(mesh_.edge(HalfedgeId(o)));
            s.near_half = half_sharpness_[o];
            s.far_half = twin(o) == k_none ? s.sharpness : half_sharpness_[twin(o)];
        }
        ring.spokes.push_back(s);
    }
    if (ring.boundary) {
        LoopRing::Spoke s;
        s.point = control(prev(fan.back()));
        s.sharpness = s.near_half = s.far_half = k_sharpness_infinity;
        ring.spokes.push_back(s);
    }
    return ring;
}

void LoopPatches::halve_edges() {
    half_sharpness_.assign(mesh_.halfedge_count(), 0.0f);
    const bool chaikin = mesh_.crease_method() == CreaseMethod::chaikin;
    for_each_index(mesh_.halfedge_count(), [&](std::uint32_t h) {
        const float s = mesh_.sharpness(mesh_.edge(HalfedgeId(h)));
        if (!is_sharp(s)) return;
        if (!chaikin || !is_semi_sharp(s)) {
            half_sharpness_[h] = child_sharpness(s);
            return;
        }
        std::vector<std::uint32_t> fan;
        outgoing(VertexId(origin(h)), h, fan);
        std::vector<float> around;
        for (const std::uint32_t o : fan) around.push_back(mesh_.sharpness(mesh_.edge(HalfedgeId(o))));
        if (mesh_.is_boundary(VertexId(origin(h)))) around.push_back(k_sharpness_infinity);
        half_sharpness_[h] = child_sharpness_chaikin(s, around);
    });
}

void LoopPatches::first_step(const RunContext&) {
    const std::uint32_t vertex_count = mesh_.vertex_count(), edge_count = mesh_.edge_count();
    bool any_sharp = false;
    for (std::uint32_t e = 0; e < edge_count && !any_sharp; ++e) any_sharp = is_sharp(mesh_.sharpness(EdgeId(e)));
    if (any_sharp) halve_edges();
    for (const Vec3d& p : mesh_.positions())
        largest_coordinate_ = std::max({largest_coordinate_, std::abs(p.x), std::abs(p.y), std::abs(p.z)});

    vertex_points_.resize(vertex_count);
    smooth_.assign(vertex_count, 0);
    for_each_index(vertex_count, [&](std::uint32_t v) {
        const std::uint32_t start = mesh_.vertex_halfedge(VertexId(v)).value;
        if (start == k_none) return;
        bool smooth = !mesh_.is_boundary(VertexId(v)) && !is_sharp(mesh_.sharpness(VertexId(v)));
        Vec3d sum(0);
        int n = 0;
        for (std::uint32_t o = start; smooth;) {
            smooth = !any_sharp || !is_sharp(mesh_.sharpness(mesh_.edge(HalfedgeId(o))));
            o = prev(o);
            sum += control(o);
            ++n;
            o = twin(o);
            if (o == start) break;
        }
        smooth_[v] = smooth ? 1 : 0;
        if (smooth) {
            const RingMask mask = Loop::vertex_mask(n);
            vertex_points_[v] = mask.vertex * mesh_.position(VertexId(v)) + mask.edge * sum;
        } else {
            vertex_points_[v] = control_ring(start).vertex_point();
        }
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
        if (!any_sharp) return;
        const double crease = edge_crease_weight(mesh_.sharpness(EdgeId(e)), half_sharpness_[h], half_sharpness_[t]);
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
    auto fresh = std::make_unique<LoopStarChain>(valence, detail::loop_star_size(valence));
    if (first_level)
        gather_first(h, valence, fresh->points());
    else
        gather_control(h, valence, fresh->points());
    if (grown_[h].star.compare_exchange_strong(known, fresh.get(), std::memory_order_acq_rel)) known = fresh.release();
    return *known;
}

const LoopNode& LoopPatches::generic_root(std::uint32_t h) const {
    LoopNode* known = grown_[h].node.load(std::memory_order_acquire);
    if (known != nullptr) return *known;
    LoopRings rings{{control_ring(h), control_ring(h + 1), control_ring(h + 2)}};
    auto fresh = std::make_unique<LoopNode>(std::move(rings));
    if (grown_[h].node.compare_exchange_strong(known, fresh.get(), std::memory_order_acq_rel)) known = fresh.release();
    return *known;
}

void LoopPatches::root_cell(HalfedgeId root, LoopCell& out) const {
    const std::uint32_t h = root.value;
    const RootKind kind = kind_[h / 3];
    out.turn = 0;
    switch (kind) {
        case RootKind::generic:
            generic_root(h).cell(out);
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
        cell.node->child(quarter).cell(out);
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

namespace {

/// Which corner a point is, or -1.
int corner_at(const Bary& b) { return b[0] == 1 ? 0 : b[1] == 1 ? 1 : b[2] == 1 ? 2 : -1; }

}  // namespace

Vec3d LoopPatches::position(const LoopCell& start, const Bary& at) const {
    if (start.kind == LoopCell::Kind::regular) return detail::box_spline_position(start.net, at);
    LoopCell cell = start;
    Bary b = at;
    while (cell.kind != LoopCell::Kind::regular) {
        const int corner = corner_at(b);
        if (cell.kind == LoopCell::Kind::star && corner == 0)
            return detail::loop_star_limit(cell.star->valence(), cell.star->points());
        if (cell.kind == LoopCell::Kind::generic && corner >= 0)
            return cell.node->rings().corner[corner].limit().position;
        if (cell.kind == LoopCell::Kind::split && corner >= 0)
            return vertex_limit(3 * cell.face + static_cast<std::uint32_t>(corner));
        const int quarter = detail::quarter_of(b);
        b = detail::in_quarter(b, quarter);
        child(cell, quarter, cell);
        b = detail::turned(b, cell.turn);
    }
    return detail::box_spline_position(cell.net, b);
}

/// Limit of origin(h), the ring taken from the same half-edge for every root.
Vec3d LoopPatches::vertex_limit(std::uint32_t h) const {
    const VertexId v(origin(h));
    const std::uint32_t start = mesh_.vertex_halfedge(v).value;
    if (!smooth_[v.value]) return control_ring(start).limit().position;
    Vec3d sum(0);
    for (std::uint32_t o = start;;) {
        o = prev(o);
        sum += control(o);
        o = twin(o);
        if (o == start) break;
    }
    const RingMask mask = Loop::limit_mask(static_cast<int>(mesh_.face_valence(v)));
    return mask.vertex * mesh_.position(v) + mask.edge * sum;
}

Vec3d LoopPatches::limit(HalfedgeId root, LatticePoint at, int level) const {
    const std::uint32_t side = std::uint32_t{1} << level;
    if (at.x == side) return vertex_limit(root.value + 1);
    if (at.y == side) return vertex_limit(root.value + 2);
    if (at.x == 0 && at.y == 0) return vertex_limit(root.value);
    const double scale = 1.0 / side;
    const Bary b{(side - at.x - at.y) * scale, at.x * scale, at.y * scale};
    LoopCell cell;
    root_cell(root, cell);
    return position(cell, detail::turned(b, cell.turn));
}

SurfacePoint LoopPatches::evaluate(HalfedgeId root, double x, double y) const {
    Bary b{1 - x - y, x, y};
    // The parameters' directions in the cell's frame: `scale` times those of the root, with corners renumbered by
    // `turn`.
    double scale = 1;
    int turn = 0;
    if (const int corner = corner_at(b); corner >= 0) {
        SurfacePoint out = control_ring(root.value + static_cast<std::uint32_t>(corner)).limit();
        out.position = vertex_limit(root.value + static_cast<std::uint32_t>(corner));
        return out;
    }
    LoopCell cell;
    root_cell(root, cell);
    b = detail::turned(b, cell.turn);
    turn = cell.turn;
    while (cell.kind != LoopCell::Kind::regular) {
        const int corner = corner_at(b);
        if (cell.kind == LoopCell::Kind::star && corner == 0) return star_corner(*cell.star);
        if (cell.kind == LoopCell::Kind::generic && corner >= 0) return cell.node->rings().corner[corner].limit();
        const int quarter = detail::quarter_of(b);
        b = detail::in_quarter(b, quarter);
        scale *= quarter == 3 ? -2 : 2;
        child(cell, quarter, cell);
        b = detail::turned(b, cell.turn);
        turn = (turn + cell.turn) % 3;
    }
    const detail::BoxSplinePoint p = detail::box_spline_point(cell.net, b);
    // Root coordinates grow by (-1, 1, 0) along x and (-1, 0, 1) along y.
    constexpr std::array<double, 3> along_x{-1, 1, 0}, along_y{-1, 0, 1};
    const double xx = scale * along_x[(1 + turn) % 3], xy = scale * along_x[(2 + turn) % 3];
    const double yx = scale * along_y[(1 + turn) % 3], yy = scale * along_y[(2 + turn) % 3];
    SurfacePoint out;
    out.position = p.position;
    out.du = xx * p.dx + xy * p.dy;
    out.dv = yx * p.dx + yy * p.dy;
    out.duu = xx * xx * p.dxx + 2 * xx * xy * p.dxy + xy * xy * p.dyy;
    out.duv = xx * yx * p.dxx + (xx * yy + xy * yx) * p.dxy + xy * yy * p.dyy;
    out.dvv = yx * yx * p.dxx + 2 * yx * yy * p.dxy + yy * yy * p.dyy;
    out.has_second = out.has_derivatives = true;
    out.normal = unit_or_zero(glm::cross(out.du, out.dv));
    return out;
}

SurfacePoint LoopPatches::vertex(HalfedgeId root, LatticePoint at, int level) const {
    const double scale = 1.0 / (std::uint32_t{1} << level);
    SurfacePoint out = evaluate(root, at.x * scale, at.y * scale);
    out.position = limit(root, at, level);
    // On side s of the root, at parameter t along it?
    const std::uint32_t side = std::uint32_t{1} << level, z = side - at.x - at.y;
    const std::array<std::uint32_t, 3> b{z, at.x, at.y};
    for (std::uint32_t s = 0; s < 3; ++s) {
        if (b[(s + 2) % 3] != 0 || b[s] == 0 || b[(s + 1) % 3] == 0) continue;
        const std::uint32_t h = root.value + s, t = twin(h);
        if (t == k_none || mesh_.sharpness(mesh_.edge(HalfedgeId(h))) != k_sharpness_infinity) continue;
        const Vec2d from = k_corner_parameters[t % 3], to = k_corner_parameters[(t + 1) % 3];
        const Vec2d there = from + (b[s] * scale) * (to - from);
        const SurfacePoint other = evaluate(HalfedgeId(t - t % 3), there.x, there.y);
        out.normal = unit_or_zero(out.normal + other.normal);
    }
    return out;
}

}  // namespace tetrakis
