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
using detail::CornerRing;
using detail::for_each_outgoing;
using detail::LoopCell;
using detail::LoopNode;
using detail::LoopRings;
using detail::LoopStarChain;
using detail::Net12;

namespace {

constexpr std::uint32_t k_none = HalfedgeId::none;

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
        first_step(context);
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

Box3d LoopPatches::bounds(FaceId face) const {
    // The points of level 1 that the face's quarters depend on: all weights are positive.
    Box3d box;
    for (std::uint32_t h = 3 * face.value; h < 3 * face.value + 3; ++h) {
        box.add(vertex_point(h));
        for_each_outgoing(mesh_, VertexId(origin(h)), [&](HalfedgeId o) {
            box.add(edge_point(o.value));
            if (const std::uint32_t last = prev(o.value); twin(last) == k_none) box.add(edge_point(last));
        });
    }
    return box;
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

void LoopPatches::first_step(const RunContext&) {
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
    fresh.find_reach();
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

}  // namespace tetrakis
