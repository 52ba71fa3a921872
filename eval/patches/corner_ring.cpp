#include "corner_ring.hpp"

#include "../../refine/rules/face_normals.hpp"
#include "../../schemes/analysis/limit_search.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "../../schemes/rules/loop.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <span>
#include <stdexcept>
#include <utility>

namespace tetrakis::detail {

namespace {

float half_of(const CornerRing& ring, float sharpness, std::span<const float> at_end) {
    return ring.chaikin ? child_sharpness_chaikin(sharpness, at_end) : child_sharpness(sharpness);
}

bool is_crease(const CornerRing::Spoke& s) { return is_sharp(s.sharpness); }

/// Limit masks of a sector or of a whole ring. At a corner without a tangent plane, the tangent masks span a plane
/// fitted to the edges.
ClosedMasks masks_of(SchemeKind scheme, const FanShape& shape) {
    SchemeInfo info = *find_scheme(name(scheme));
    info.rings = 1;  // all that the weights of limits and tangents reach
    if (!shape.corner) {
        const ClosedMasks masks = limit_masks(info, shape, {});
        if (masks.limit.empty()) throw std::invalid_argument("so many edges around a vertex have no limit mask");
        return masks;
    }
    ClosedMasks masks = shape.boundary ? info.closed_masks(shape, {})
                        : scheme == SchemeKind::catmull_clark
                            ? CatmullClark::ring_closed_masks(shape.faces, {.vertex = 1})
                            : ring_closed_masks(shape.faces, {.vertex = 1});
    const bool fit = masks.tangent1.empty();
    for (int i = 0; fit && i <= shape.faces; ++i) {
        const double angle = i * std::numbers::pi / shape.faces;
        masks.tangent1.emplace_back(FanLabel{i, 1, 0}, std::cos(angle));
        masks.tangent2.emplace_back(FanLabel{i, 1, 0}, std::sin(angle));
    }
    return masks;
}

/// masks_of() a shape, computed once per thread.
const ClosedMasks& known_masks(SchemeKind scheme, const FanShape& shape) {
    thread_local std::map<std::pair<SchemeKind, FanShape>, ClosedMasks> known;
    const auto at = known.find({scheme, shape});
    return at != known.end() ? at->second : known.try_emplace({scheme, shape}, masks_of(scheme, shape)).first->second;
}

/// A mask applied to differences from the centre, so that a far origin costs no digits. Zero if it is only rounding.
/// @param first  the spoke on which the mask's sector 0 begins
Vec3d weighed(const CornerRing& ring, const ClosedMasks::Mask& mask, int first) {
    constexpr double k_rounding = 1e-12;
    Vec3d sum(0);
    double size = 0;
    for (const auto& [label, weight] : mask) {
        if (label.a == 0) continue;
        const CornerRing::Spoke& spoke = ring.spoke(first + label.sector);
        const Vec3d term = weight * ((label.b == 0 ? spoke.point : spoke.face) - ring.centre);
        sum += term;
        size += glm::length(term);
    }
    return glm::length(sum) > k_rounding * size ? sum : Vec3d(0);
}

}  // namespace

void CornerRing::halve() {
    std::vector<float> around;  // of no use to the uniform method
    for (const Spoke& s : spokes)
        if (chaikin) around.push_back(s.sharpness);
    for (Spoke& s : spokes)
        if (is_sharp(s.sharpness)) s.near_half = half_of(*this, s.sharpness, around);
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
    ShortList<float, 8> around, halves;
    for (const Spoke& s : spokes) around.push_back(s.sharpness), halves.push_back(s.near_half);
    const VertexBlend blend = vertex_blend(around, sharpness, halves, child_sharpness(sharpness));
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
    // The ends' rings one level down give the sharpness of each half's own half.
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

std::optional<CornerRing::Sector> CornerRing::sector(int at) const {
    const auto sharp = std::count_if(spokes.begin(), spokes.end(), is_crease);
    if (sharp < 2) return std::nullopt;
    Sector sector{at, 1, is_sharp(sharpness) || sharp > 2};
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
    SurfacePoint out{.position = centre, .has_second = false, .has_derivatives = false};
    Vec3d normals(0);
    for (int at = cell, done = 0; done < faces();) {
        FanShape shape{.faces = faces(), .corner = is_sharp(sharpness)};
        if (const std::optional<Sector> between = sector(at)) {
            at = between->first;
            shape = {.faces = between->faces, .boundary = true, .corner = between->corner};
        } else if (!shape.corner) {
            const auto sharp = std::find_if(spokes.begin(), spokes.end(), is_crease);
            shape.dart = sharp != spokes.end();
            at = shape.dart ? static_cast<int>(sharp - spokes.begin()) : 0;
        }
        const ClosedMasks& masks = known_masks(scheme, shape);
        const Vec3d t1 = weighed(*this, masks.tangent1, at), t2 = weighed(*this, masks.tangent2, at);
        normals += FaceNormals::at_corner(Vec3d(0), t1, t2);
        if (done == 0) {
            out.position += weighed(*this, masks.limit, at);
            out.du = t1;
            out.dv = t2;
        }
        done += shape.faces;
        at = wrap(at + shape.faces) == size() - 1 && boundary ? 0 : at + shape.faces;
    }
    out.normal = unit_of_sum(normals);
    if (out.normal != Vec3d(0)) return out;
    FaceNormals around;
    for (int i = 0; i < faces(); ++i) {
        const Vec3d a = spoke(i).point, b = spoke(i + 1).point;
        if (scheme == SchemeKind::loop)
            around.add(std::array{centre, a, b}, 0);
        else
            around.add(std::array{centre, a, spoke(i).face, b}, 0);
    }
    out.normal = around.normal();
    return out;
}

CornerRing control_ring(const ControlMesh& mesh, SchemeKind scheme, HalfedgeId h, std::span<const Vec3d> face_points) {
    const VertexId v = mesh.origin(h);
    CornerRing ring;
    ring.scheme = scheme;
    ring.centre = mesh.position(v);
    ring.sharpness = mesh.sharpness(v);
    ring.boundary = mesh.is_boundary(v);
    ring.chaikin = mesh.crease_method() == CreaseMethod::chaikin;
    ring.spokes.reserve(mesh.face_valence(v) + std::size_t{1});
    HalfedgeId last;
    for_each_outgoing(mesh, v, [&](HalfedgeId o) {
        if (o == h) ring.cell = ring.size();
        CornerRing::Spoke s{mesh.position(mesh.target(o)), Vec3d(0), mesh.sharpness(mesh.edge(o))};
        if (is_sharp(s.sharpness)) s.far_half = mesh.twin(o).valid() ? half_sharpness(mesh, mesh.twin(o)) : s.sharpness;
        last = mesh.prev(o);
        if (!face_points.empty())
            s.face = 4.0 * face_points[mesh.face(o).value] - (ring.centre + s.point + mesh.position(mesh.origin(last)));
        ring.spokes.push_back(s);
    });
    if (ring.boundary)
        ring.spokes.push_back(
            {mesh.position(mesh.origin(last)), Vec3d(0), k_sharpness_infinity, 0, k_sharpness_infinity});
    ring.halve();
    return ring;
}

float half_sharpness(const ControlMesh& mesh, HalfedgeId h) {
    const float s = mesh.sharpness(mesh.edge(h));
    if (mesh.crease_method() != CreaseMethod::chaikin || !is_semi_sharp(s)) return child_sharpness(s);
    std::vector<float> around;  // infinite ones do not count in the mean
    for_each_outgoing(mesh, mesh.origin(h), [&](HalfedgeId o) { around.push_back(mesh.sharpness(mesh.edge(o))); });
    return child_sharpness_chaikin(s, around);
}

template <std::size_t Corners>
std::array<CellRings<Corners>, 4> CellRings<Corners>::children() const {
    constexpr bool k_quads = Corners == 4;
    std::array<CellRings, 4> out;
    std::array<CornerRing, Corners> child;
    for (std::size_t k = 0; k < Corners; ++k) child[k] = corner[k].child();
    CornerRing centre;  // of a quad
    centre.scheme = corner[0].scheme;
    centre.chaikin = corner[0].chaikin;
    if (k_quads) centre.centre = corner[0].face_point(corner[0].cell);
    for (std::size_t k = 0; k < Corners; ++k) {
        const std::size_t next = (k + 1) % Corners;
        CornerRing middle = side_ring(corner[k], corner[next], child[k], child[next]);
        middle.cell = k_quads ? 1 : 2;
        out[k].corner[next] = middle;
        middle.cell = 0;
        out[next].corner[k] = middle;
        middle.cell = 1;
        if (k_quads)
            centre.spokes.push_back({middle.centre, child[next].centre});
        else
            out[3].corner[(k + 2) % Corners] = std::move(middle);
    }
    for (std::size_t k = 0; k < Corners; ++k) {
        out[k].corner[k] = std::move(child[k]);
        centre.cell = static_cast<int>((k + 3) % Corners);
        if (k_quads) out[k].corner[(k + 2) % Corners] = centre;
    }
    return out;
}

template <std::size_t Corners>
std::vector<Vec3d> CellRings<Corners>::points() const {
    std::vector<Vec3d> out;
    for (const CornerRing& ring : corner) ring.add_points(out);
    return out;
}

template <std::size_t Corners>
std::size_t CellRings<Corners>::memory_bytes() const {
    std::size_t bytes = sizeof(CellRings);
    for (const CornerRing& ring : corner) bytes += ring.spokes.capacity() * sizeof(CornerRing::Spoke);
    return bytes;
}

template struct CellRings<3>;
template struct CellRings<4>;

}  // namespace tetrakis::detail
