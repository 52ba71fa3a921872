#include "corner_ring.hpp"

#include "../../schemes/analysis/ring_limit.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/loop.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace tetrakis::detail {

namespace {

float half_of(const CornerRing& ring, float sharpness, std::span<const float> at_end) {
    return ring.chaikin ? child_sharpness_chaikin(sharpness, at_end) : child_sharpness(sharpness);
}

std::vector<float> by_spoke(const CornerRing& ring, float CornerRing::Spoke::*sharpness) {
    std::vector<float> values;
    values.reserve(ring.spokes.size());
    for (const CornerRing::Spoke& s : ring.spokes) values.push_back(s.*sharpness);
    return values;
}

}  // namespace

CornerRing CornerRing::smooth(SchemeKind scheme, int valence, const Vec3d* points) {
    CornerRing ring;
    ring.scheme = scheme;
    ring.centre = *points++;
    ring.spokes.resize(static_cast<std::size_t>(valence));
    for (Spoke& s : ring.spokes) {
        s.point = *points++;
        if (scheme == SchemeKind::catmull_clark) s.face = *points++;
    }
    return ring;
}

void CornerRing::halve() {
    const std::vector<float> sharpness_around = by_spoke(*this, &Spoke::sharpness);
    for (Spoke& s : spokes) s.near_half = half_of(*this, s.sharpness, sharpness_around);
}

Vec3d CornerRing::face_point(int i) const {
    const Spoke& s = spoke(i);
    return 0.25 * (centre + s.point + s.face + spoke(i + 1).point);
}

Vec3d CornerRing::edge_point(int i) const {
    const Spoke& s = spoke(i);
    const Vec3d ends = centre + s.point, middle = 0.5 * ends;
    const double crease = edge_crease_weight(s.sharpness, s.near_half, s.far_half);
    if (crease == 1 || (boundary && (wrap(i) == 0 || wrap(i) == size() - 1))) return middle;
    const Vec3d smooth = scheme == SchemeKind::loop
                             ? Loop::edge_end * ends + Loop::edge_opposite * (spoke(i - 1).point + spoke(i + 1).point)
                             : 0.25 * (ends + face_point(i) + face_point(i - 1));
    return crease == 0 ? smooth : (1 - crease) * smooth + crease * middle;
}

Vec3d CornerRing::vertex_point() const {
    const VertexBlend blend = vertex_blend(by_spoke(*this, &Spoke::sharpness), sharpness,
                                           by_spoke(*this, &Spoke::near_half), child_sharpness(sharpness));
    Vec3d out(0);
    if (blend.smooth != 0) {
        const double n = size();
        Vec3d sum(0), faces_sum(0);
        for (int i = 0; i < size(); ++i) {
            sum += spokes[static_cast<std::size_t>(i)].point;
            if (scheme == SchemeKind::catmull_clark) faces_sum += face_point(i);
        }
        const RingMask mask =
            scheme == SchemeKind::loop ? Loop::vertex_mask(size()) : RingMask{(n - 2) / n, 1 / (n * n), 1 / (n * n)};
        out += blend.smooth * (mask.vertex * centre + mask.edge * sum + mask.face * faces_sum);
    }
    if (blend.corner != 0) out += blend.corner * centre;
    if (blend.crease.weight != 0)
        out += blend.crease.weight *
               (k_crease_vertex_mask.vertex * centre +
                k_crease_vertex_mask.neighbour * (spoke(blend.crease.a).point + spoke(blend.crease.b).point));
    return out;
}

CornerRing CornerRing::child() const {
    CornerRing out;
    out.scheme = scheme;
    out.centre = vertex_point();
    out.sharpness = child_sharpness(sharpness);
    out.boundary = boundary;
    out.chaikin = chaikin;
    out.cell = cell;
    out.spokes.resize(spokes.size());
    for (int i = 0; i < size(); ++i) {
        const Spoke& above = spoke(i);
        Spoke& s = out.spokes[static_cast<std::size_t>(i)];
        s.point = edge_point(i);
        if (scheme == SchemeKind::catmull_clark && i < faces()) s.face = face_point(i);
        s.sharpness = above.near_half;
        // The spoke's other end is the midpoint of this edge, where only the edge's two halves can be sharp.
        s.far_half = half_of(*this, s.sharpness, std::array{above.near_half, above.far_half});
    }
    out.halve();
    return out;
}

CornerRing side_ring(const CornerRing& from, const CornerRing& to, const CornerRing& from_child,
                     const CornerRing& to_child) {
    CornerRing ring;
    ring.scheme = from.scheme;
    ring.chaikin = from.chaikin;
    ring.boundary = from.boundary && from.cell == 0;
    ring.centre = from.edge_point(from.cell);
    // The ends' rings one level down give the halves of the halves.
    const auto add_half = [&](const CornerRing& child, int spoke, const Vec3d& face) {
        const CornerRing::Spoke& s = child.spoke(spoke);
        ring.spokes.push_back({child.centre, face, s.sharpness, 0, s.near_half});
    };
    const auto add = [&](const Vec3d& point, const Vec3d& face) { ring.spokes.push_back({point, face}); };
    const Vec3d beside_to = to.edge_point(to.cell), beside_from = from.edge_point(from.cell + 1);
    if (ring.scheme == SchemeKind::loop) {
        add_half(to_child, to.cell + 1, {});
        add(beside_to, {});
        add(beside_from, {});
    } else {
        add_half(to_child, to.cell + 1, beside_to);
        add(from.face_point(from.cell), beside_from);
    }
    const Vec3d beyond_from = ring.boundary ? Vec3d(0) : from.edge_point(from.cell - 1),
                beyond_to = ring.boundary ? Vec3d(0) : to.edge_point(to.cell + 2);
    add_half(from_child, from.cell, beyond_from);
    if (!ring.boundary && ring.scheme == SchemeKind::loop) {
        add(beyond_from, {});
        add(beyond_to, {});
    } else if (!ring.boundary) {
        add(from.face_point(from.cell - 1), beyond_to);
    }
    ring.halve();
    return ring;
}

bool CornerRing::is_stationary() const {
    return !is_semi_sharp(sharpness) &&
           std::none_of(spokes.begin(), spokes.end(), [](const Spoke& s) { return is_semi_sharp(s.sharpness); });
}

bool CornerRing::is_smooth() const {
    return !boundary && !is_sharp(sharpness) &&
           std::none_of(spokes.begin(), spokes.end(), [](const Spoke& s) { return is_sharp(s.sharpness); });
}

std::optional<CornerRing::Sector> CornerRing::sector() const {
    const auto sharp =
        std::count_if(spokes.begin(), spokes.end(), [](const Spoke& s) { return is_sharp(s.sharpness); });
    if (sharp < 2) return std::nullopt;
    Sector sector{cell, 1, is_sharp(sharpness) || sharp > 2};
    while (!is_sharp(spoke(sector.first).sharpness)) --sector.first, ++sector.faces;
    while (!is_sharp(spoke(sector.first + sector.faces).sharpness)) ++sector.faces;
    return sector;
}

void CornerRing::add_points(std::vector<Vec3d>& points) const {
    points.push_back(centre);
    for (int i = 0; i < size(); ++i) {
        points.push_back(spokes[static_cast<std::size_t>(i)].point);
        if (scheme == SchemeKind::catmull_clark && i < faces())
            points.push_back(spokes[static_cast<std::size_t>(i)].face);
    }
}

SurfacePoint CornerRing::limit() const {
    if (!is_stationary()) return child().limit();
    RingShape shape;
    shape.faces = faces();
    shape.boundary = boundary;
    shape.corner = is_sharp(sharpness);
    for (const Spoke& s : spokes) shape.sharp.push_back(is_sharp(s.sharpness) ? 1 : 0);
    std::vector<Vec3d> ring;
    add_points(ring);
    const RingLimit& limit = ring_limit(scheme, shape);
    const RingLimit::Sector* sector = &limit.sectors.front();
    for (const RingLimit::Sector& s : limit.sectors)
        if (wrap(cell - s.first_edge) < s.faces) sector = &s;
    SurfacePoint out;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        out.position += limit.position[i] * ring[i];
        out.du += sector->tangent1[i] * ring[i];
        out.dv += sector->tangent2[i] * ring[i];
    }
    out.has_second = out.has_derivatives = false;
    out.normal = limit_normal(scheme, shape, limit, ring);
    return out;
}

}  // namespace tetrakis::detail
