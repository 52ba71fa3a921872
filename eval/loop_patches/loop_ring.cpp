#include "loop_ring.hpp"

#include "../../schemes/analysis/ring_limit.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/loop.hpp"

#include <cmath>

namespace tetrakis::detail {

namespace {

float half_of(const LoopRing& ring, float sharpness, std::span<const float> at_end) {
    return ring.chaikin ? child_sharpness_chaikin(sharpness, at_end) : child_sharpness(sharpness);
}

std::vector<float> by_spoke(const LoopRing& ring, float LoopRing::Spoke::*sharpness) {
    std::vector<float> values;
    values.reserve(ring.spokes.size());
    for (const LoopRing::Spoke& s : ring.spokes) values.push_back(s.*sharpness);
    return values;
}

}  // namespace

void LoopRing::halve() {
    const std::vector<float> sharpness_around = by_spoke(*this, &Spoke::sharpness);
    for (Spoke& s : spokes) s.near_half = half_of(*this, s.sharpness, sharpness_around);
}

Vec3d LoopRing::edge_point(int i) const {
    const Spoke& s = spokes[i];
    const double crease = edge_crease_weight(s.sharpness, s.near_half, s.far_half);
    const Vec3d middle = 0.5 * (centre + s.point);
    if (crease == 1 || (boundary && (i == 0 || i == size() - 1))) return middle;
    const Vec3d smooth = Loop::edge_end * (centre + s.point) +
                         Loop::edge_opposite * (spokes[wrap(i - 1)].point + spokes[wrap(i + 1)].point);
    return crease == 0 ? smooth : (1 - crease) * smooth + crease * middle;
}

Vec3d LoopRing::vertex_point() const {
    const VertexBlend blend = vertex_blend(by_spoke(*this, &Spoke::sharpness), sharpness,
                                           by_spoke(*this, &Spoke::near_half), child_sharpness(sharpness));
    Vec3d out(0);
    if (blend.smooth != 0) {
        const RingMask mask = Loop::vertex_mask(size());
        Vec3d sum(0);
        for (const Spoke& s : spokes) sum += s.point;
        out += blend.smooth * (mask.vertex * centre + mask.edge * sum);
    }
    if (blend.corner != 0) out += blend.corner * centre;
    if (blend.crease.weight != 0)
        out += blend.crease.weight *
               (k_crease_vertex_mask.vertex * centre +
                k_crease_vertex_mask.neighbour * (spokes[blend.crease.a].point + spokes[blend.crease.b].point));
    return out;
}

LoopRing LoopRing::child() const {
    LoopRing out;
    out.centre = vertex_point();
    out.sharpness = child_sharpness(sharpness);
    out.boundary = boundary;
    out.chaikin = chaikin;
    out.cell = cell;
    out.spokes.resize(spokes.size());
    for (int i = 0; i < size(); ++i) {
        Spoke& s = out.spokes[i];
        s.point = edge_point(i);
        s.sharpness = spokes[i].near_half;
        // The spoke's other end is the midpoint of this edge, where only the edge's two halves can be sharp.
        const std::array<float, 2> at_middle{spokes[i].near_half, spokes[i].far_half};
        s.far_half = half_of(*this, s.sharpness, at_middle);
    }
    out.halve();
    return out;
}

/// Ring of the midpoint of an edge; `from` and `to` are the rings of its ends, one level up, in the same cell, the cell
/// between them on the left of the edge.
static LoopRing edge_ring(const LoopRing& from, const LoopRing& to) {
    // The ends' rings one level down give the halves of the halves.
    const int out_spoke = from.cell, back_spoke = to.wrap(to.cell + 1);
    const LoopRing from_child = from.child(), to_child = to.child();
    const bool boundary = from.boundary && from.cell == 0 && to.boundary && to.cell + 2 == to.size();
    LoopRing ring;
    ring.chaikin = from.chaikin;
    ring.boundary = boundary;
    ring.centre = from.edge_point(out_spoke);
    ring.spokes.resize(boundary ? 4 : 6);
    const auto half = [&](const LoopRing& child, int spoke) {
        LoopRing::Spoke s;
        s.point = child.centre;
        s.sharpness = child.spokes[spoke].sharpness;
        s.far_half = child.spokes[spoke].near_half;
        return s;
    };
    ring.spokes[0] = half(to_child, back_spoke);
    ring.spokes[1].point = to.edge_point(to.cell);
    ring.spokes[2].point = from.edge_point(from.wrap(from.cell + 1));
    ring.spokes[3] = half(from_child, out_spoke);
    if (!boundary) {
        ring.spokes[4].point = from.edge_point(from.wrap(from.cell - 1));
        ring.spokes[5].point = to.edge_point(to.wrap(to.cell + 2));
    }
    ring.halve();
    return ring;
}

bool LoopRing::is_stationary() const {
    if (is_semi_sharp(sharpness)) return false;
    for (const Spoke& s : spokes)
        if (is_semi_sharp(s.sharpness)) return false;
    return true;
}

bool LoopRing::is_smooth() const {
    if (boundary || is_sharp(sharpness)) return false;
    for (const Spoke& s : spokes)
        if (is_sharp(s.sharpness)) return false;
    return true;
}

std::optional<std::array<Vec3d, 6>> LoopRing::regular_neighbours() const {
    std::array<Vec3d, 6> out;
    if (is_smooth()) {
        if (size() != 6) return {};
        for (int i = 0; i < 6; ++i) out[i] = spokes[wrap(cell + i)].point;
        return out;
    }
    if (!is_stationary()) return {};
    int sharp = 0;
    for (const Spoke& s : spokes) sharp += is_sharp(s.sharpness) ? 1 : 0;
    if (sharp < 2) return {};
    // The cell's sector runs from spoke `first` over `faces` triangles.
    int first = cell, faces = 1;
    while (!is_sharp(spokes[wrap(first)].sharpness)) --first, ++faces;
    while (!is_sharp(spokes[wrap(first + faces)].sharpness)) ++faces;
    const int offset = cell - first;
    const bool corner = is_sharp(sharpness) || sharp > 2;
    const auto p = [&](int i) { return spokes[wrap(first + i)].point; };
    if (!corner && faces == 3) {
        const std::array<Vec3d, 6> around{p(0), p(1), p(2), p(3), centre + p(3) - p(2), centre + p(0) - p(1)};
        for (int i = 0; i < 6; ++i) out[i] = around[(i + offset) % 6];
        return out;
    }
    if (corner && faces == 1)
        return std::array<Vec3d, 6>{
            p(0), p(1), centre + p(1) - p(0), 2.0 * centre - p(0), 2.0 * centre - p(1), centre + p(0) - p(1)};
    return {};
}

SurfacePoint LoopRing::limit() const {
    if (!is_stationary()) return child().limit();
    RingShape shape;
    shape.faces = size() - (boundary ? 1 : 0);
    shape.boundary = boundary;
    shape.corner = is_sharp(sharpness);
    shape.sharp.resize(spokes.size());
    std::vector<Vec3d> ring{centre};
    for (int i = 0; i < size(); ++i) {
        shape.sharp[i] = is_sharp(spokes[i].sharpness) ? 1 : 0;
        ring.push_back(spokes[i].point);
    }
    const RingLimit& limit = ring_limit(SchemeKind::loop, shape);
    const auto apply = [&](const std::vector<double>& weights) {
        Vec3d sum(0);
        for (std::size_t i = 0; i < ring.size(); ++i) sum += weights[i] * ring[i];
        return sum;
    };
    const RingLimit::Sector* sector = &limit.sectors.front();
    for (const RingLimit::Sector& s : limit.sectors)
        if (wrap(cell - s.first_edge) < s.faces) sector = &s;
    SurfacePoint out;
    out.position = apply(limit.position);
    out.du = apply(sector->tangent1);
    out.dv = apply(sector->tangent2);
    out.has_second = out.has_derivatives = false;
    out.normal = limit_normal(SchemeKind::loop, shape, limit, ring);
    return out;
}

std::array<LoopRings, 4> LoopRings::children() const {
    std::array<LoopRings, 4> out;
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        out[k].corner[k] = corner[k].child();
        LoopRing middle = edge_ring(corner[k], corner[next]);
        middle.cell = 2;
        out[k].corner[next] = middle;
        middle.cell = 0;
        out[next].corner[k] = middle;
        middle.cell = 1;
        out[3].corner[(k + 2) % 3] = std::move(middle);
    }
    return out;
}

std::optional<Net12> LoopRings::regular_net() const {
    const auto a = corner[0].regular_neighbours();
    if (!a) return {};
    const auto b = corner[1].regular_neighbours();
    if (!b) return {};
    const auto c = corner[2].regular_neighbours();
    if (!c) return {};
    return Net12{corner[0].centre, corner[1].centre, corner[2].centre, (*a)[2], (*a)[3], (*a)[4],
                 (*a)[5],          (*b)[3],          (*b)[4],          (*b)[5], (*c)[3], (*c)[4]};
}

int LoopRings::star_corner() const {
    for (int k = 0; k < 3; ++k)
        if (corner[k].is_smooth() && corner[k].size() != 6)
            return corner[(k + 1) % 3].regular_neighbours() && corner[(k + 2) % 3].regular_neighbours() ? k : -1;
    return -1;
}

std::vector<Vec3d> LoopRings::star_points(int k) const {
    const LoopRing& centre = corner[k];
    std::vector<Vec3d> out{centre.centre};
    for (int i = 0; i < centre.size(); ++i) out.push_back(centre.spokes[centre.wrap(centre.cell + i)].point);
    const auto a = *corner[(k + 1) % 3].regular_neighbours();
    const auto b = *corner[(k + 2) % 3].regular_neighbours();
    out.insert(out.end(), {a[3], a[4], a[5], b[3], b[4]});
    return out;
}

std::vector<Vec3d> LoopRings::points() const {
    std::vector<Vec3d> out;
    for (const LoopRing& ring : corner) {
        out.push_back(ring.centre);
        for (const LoopRing::Spoke& s : ring.spokes) out.push_back(s.point);
    }
    return out;
}

}  // namespace tetrakis::detail
