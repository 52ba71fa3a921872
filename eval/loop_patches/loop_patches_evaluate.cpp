#include "loop_patches.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <cmath>
#include <span>

// Positions and derivatives on the patch tree that loop_patches.cpp builds.
namespace tetrakis {

using detail::Bary;
using detail::corner_at;
using detail::CornerRing;
using detail::LoopCell;
using detail::LoopRings;
using detail::LoopStarChain;
using detail::Net12;

namespace {

constexpr std::array<Vec2d, 3> k_corner_parameters{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};

/// Every way to a position ends here, so that all of them have the same bits.
Vec3d net_position(const Net12& net, const Bary& b) {
    const int corner = corner_at(b);
    return corner < 0 ? detail::box_spline_position(net, b) : detail::box_spline_corner(net, corner);
}

}  // namespace

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
