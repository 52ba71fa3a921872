#include "loop_patches.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/loop.hpp"
#include "../../schemes/rules/ring_limit.hpp"

#include <algorithm>
#include <cmath>
#include <span>

// Positions and derivatives on the patch tree that loop_patches.cpp builds.
namespace tetrakis {

using detail::Bary;
using detail::corner_at;
using detail::LoopCell;
using detail::LoopRing;
using detail::LoopRings;
using detail::LoopStarChain;
using detail::Net12;

namespace {

constexpr std::array<Vec2d, 3> k_corner_parameters{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};

/// An interior smooth vertex from its ring, itself first: the tangents are the ring's cosine and sine sums, the cosine
/// along the first edge.
SurfacePoint smooth_corner(std::span<const Vec3d> ring) {
    const int valence = static_cast<int>(ring.size()) - 1;
    const RingLimit& limit = smooth_ring_limit(SchemeKind::loop, valence);
    SurfacePoint out;
    out.position = detail::loop_star_limit(valence, ring.data());
    for (std::size_t i = 0; i < ring.size(); ++i) {
        out.du += limit.tangent1[i] * ring[i];
        out.dv += limit.tangent2[i] * ring[i];
    }
    out.has_second = out.has_derivatives = false;
    const RingShape shape{.faces = valence};
    out.normal = limit_normal(SchemeKind::loop, shape, limit, ring);
    return out;
}

/// Every way to a position ends here, so that all of them have the same bits.
Vec3d net_position(const Net12& net, const Bary& b) {
    const int corner = corner_at(b);
    return corner < 0 ? detail::box_spline_position(net, b) : detail::box_spline_corner(net, corner);
}

}  // namespace

Vec3d LoopPatches::position(const LoopCell& start, const Bary& at) const {
    if (start.kind == LoopCell::Kind::regular) return net_position(start.net, at);
    LoopCell cell = start;
    Bary b = at;
    while (cell.kind != LoopCell::Kind::regular) {
        const int at_corner = corner_at(b);
        if (at_corner == 0 || (at_corner > 0 && cell.kind != LoopCell::Kind::star)) return corner(cell, at_corner);
        const int quarter = detail::quarter_of(b);
        b = detail::in_quarter(b, quarter);
        child(cell, quarter, cell);
        b = detail::turned(b, cell.turn);
    }
    return net_position(cell.net, b);
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
    for (std::uint32_t o = start;; ++n) {
        o = prev(o);
        sum += control(o);
        o = twin(o);
        if (o == start) break;
    }
    const RingMask mask = detail::loop_vertex_rule(n + 1).limit;
    return mask.vertex * mesh_.position(v) + mask.edge * sum;
}

/// The surface at origin(h), seen from the root of h.
SurfacePoint LoopPatches::control_corner(std::uint32_t h) const {
    constexpr int k_common = 32;
    const VertexId v(origin(h));
    SurfacePoint out;
    if (smooth_[v.value] && mesh_.face_valence(v) <= k_common) {
        std::array<Vec3d, k_common + 1> ring;
        const std::uint32_t start = mesh_.vertex_halfedge(v).value;
        int n = 0;
        ring[0] = mesh_.position(v);
        for (std::uint32_t o = start;;) {
            ring[static_cast<std::size_t>(++n)] = control(next(o));
            o = twin(prev(o));
            if (o == start) break;
        }
        out = smooth_corner({ring.data(), static_cast<std::size_t>(n) + 1});
    } else {
        out = control_ring(h).limit();
    }
    out.position = limits_[v.value];
    return out;
}

Vec3d LoopPatches::limit(HalfedgeId root, LatticePoint at, int level) const {
    HalfedgeId none;
    LoopCell cell;
    return limit(root, at, level, none, cell);
}

void LoopPatches::limits(std::span<const Site> sites, std::span<Vec3d> out) const {
    HalfedgeId cell_root;
    LoopCell cell;
    for (std::size_t i = 0; i < sites.size(); ++i)
        out[i] = limit(sites[i].root, sites[i].at, sites[i].level, cell_root, cell);
}

/// @param cell  that of cell_root, if there is one; then of `root`, if it was looked at
Vec3d LoopPatches::limit(HalfedgeId root, LatticePoint at, int level, HalfedgeId& cell_root, LoopCell& cell) const {
    const std::uint32_t side = std::uint32_t{1} << level;
    if (at.x == side) return corner_limit(root.value + 1);
    if (at.y == side) return corner_limit(root.value + 2);
    if (at.x == 0 && at.y == 0) return corner_limit(root.value);
    const double scale = 1.0 / side;
    const Bary b{(side - at.x - at.y) * scale, at.x * scale, at.y * scale};
    if (cell_root != root) {
        root_cell(root, cell);
        cell_root = root;
    }
    return position(cell, detail::turned(b, cell.turn));
}

/// The way from a root down to where a point can be evaluated.
struct LoopPatches::Descent {
    LoopCell cell;
    Bary at;          ///< in the cell's frame
    int corner = -1;  ///< of a cell that is not regular, if the point is there
    // The parameters' directions in the cell's frame: `scale` times those of the root, with corners renumbered by
    // `turn`.
    double scale = 1;
    int turn = 0;
};

/// False where the point is a corner that stays irregular: down.corner of down.cell.
bool LoopPatches::descend(HalfedgeId root, const Bary& at, Descent& down) const {
    LoopCell& cell = down.cell;
    root_cell(root, cell);
    Bary& b = down.at;
    b = detail::turned(at, cell.turn);
    down.turn = cell.turn;
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

/// Of a corner inside a root: those of the root itself are control_corner()'s.
SurfacePoint LoopPatches::corner_point(const Descent& down) const {
    if (down.cell.kind == LoopCell::Kind::generic)
        return down.cell.node->rings().corner[static_cast<std::size_t>(down.corner)].limit();
    const LoopStarChain& star = *down.cell.star;
    return smooth_corner({star.points(), static_cast<std::size_t>(star.valence()) + 1});
}

namespace {

/// Derivatives by the root's x and y as combinations of those by a cell's.
struct Directions {
    double xx, xy, yx, yy;
    Directions(double scale, int turn) {
        // Root coordinates grow by (-1, 1, 0) along x and (-1, 0, 1) along y.
        constexpr std::array<double, 3> along_x{-1, 1, 0}, along_y{-1, 0, 1};
        const auto first = static_cast<std::size_t>((1 + turn) % 3), second = static_cast<std::size_t>((2 + turn) % 3);
        xx = scale * along_x[first], xy = scale * along_x[second];
        yx = scale * along_y[first], yy = scale * along_y[second];
    }
};

}  // namespace

/// Derivatives and normal; the rest is left as it is.
SurfacePoint LoopPatches::first_order(const Descent& down, const detail::BoxSplineTangents& t) {
    const Directions d(down.scale, down.turn);
    SurfacePoint out;
    out.du = d.xx * t.dx + d.xy * t.dy;
    out.dv = d.yx * t.dx + d.yy * t.dy;
    out.has_second = false;
    out.normal = unit_or_zero(glm::cross(out.du, out.dv));
    return out;
}

SurfacePoint LoopPatches::evaluate(HalfedgeId root, double x, double y) const {
    const Bary b{1 - x - y, x, y};
    if (const int at = corner_at(b); at >= 0) return control_corner(root.value + static_cast<std::uint32_t>(at));
    Descent down;
    if (!descend(root, b, down)) return corner_point(down);
    const detail::BoxSplinePoint p = detail::box_spline_point(down.cell.net, down.at);
    SurfacePoint out = first_order(down, {p.dx, p.dy});
    out.position = net_position(down.cell.net, down.at);
    const Directions d(down.scale, down.turn);
    out.duu = d.xx * d.xx * p.dxx + 2 * d.xx * d.xy * p.dxy + d.xy * d.xy * p.dyy;
    out.duv = d.xx * d.yx * p.dxx + (d.xx * d.yy + d.xy * d.yx) * p.dxy + d.xy * d.yy * p.dyy;
    out.dvv = d.yx * d.yx * p.dxx + 2 * d.yx * d.yy * p.dxy + d.yy * d.yy * p.dyy;
    out.has_second = true;
    return out;
}

SurfacePoint LoopPatches::tangents(HalfedgeId root, double x, double y) const {
    const Bary b{1 - x - y, x, y};
    if (const int at = corner_at(b); at >= 0) return control_corner(root.value + static_cast<std::uint32_t>(at));
    Descent down;
    if (!descend(root, b, down)) return corner_point(down);
    SurfacePoint out = first_order(down, detail::box_spline_tangents(down.cell.net, down.at));
    out.position = net_position(down.cell.net, down.at);
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
    SurfacePoint out = tangents(root, at.x * scale, at.y * scale);
    // On side s of the root, at parameter t along it?
    const std::uint32_t side = std::uint32_t{1} << level, z = side - at.x - at.y;
    const std::array<std::uint32_t, 3> b{z, at.x, at.y};
    for (std::uint32_t s = 0; s < 3; ++s) {
        if (b[(s + 2) % 3] != 0 || b[s] == 0 || b[(s + 1) % 3] == 0) continue;
        const std::uint32_t h = root.value + s, t = twin(h);
        if (t == HalfedgeId::none || mesh_.sharpness(mesh_.edge(HalfedgeId(h))) != k_sharpness_infinity) continue;
        const Vec2d from = k_corner_parameters[t % 3], to = k_corner_parameters[(t + 1) % 3];
        const Vec2d there = from + (b[s] * scale) * (to - from);
        const SurfacePoint other = tangents(HalfedgeId(t - t % 3), there.x, there.y);
        out.normal = unit_or_zero(out.normal + other.normal);
    }
    return out;
}

}  // namespace tetrakis
