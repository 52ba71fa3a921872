#include "vertex_ring.hpp"

#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "../../schemes/rules/loop.hpp"
#include "../../schemes/rules/ring_limit.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace tetrakis {

namespace {

bool any_semi_sharp(const VertexRing& ring) {
    return is_semi_sharp(ring.vertex_sharpness) ||
           std::any_of(ring.sharpness.begin(), ring.sharpness.end(), is_semi_sharp);
}

float half_beside(CreaseMethod method, float sharpness, float neighbour) {
    if (method == CreaseMethod::uniform) return child_sharpness(sharpness);
    return child_sharpness_chaikin(sharpness, std::array{sharpness, neighbour});
}

void refine_ring(SchemeKind scheme, CreaseMethod method, VertexRing& ring) {
    const bool quads = scheme == SchemeKind::catmull_clark;
    const int n = static_cast<int>(ring.sharpness.size()), faces = ring.faces, stride = quads ? 2 : 1;
    const std::vector<Vec3d>& p = ring.points;
    const auto edge = [&](int i) -> const Vec3d& { return p[1 + stride * ((i + n) % n)]; };
    const auto face = [&](int i) -> const Vec3d& { return p[2 + 2 * ((i + faces) % faces)]; };

    std::vector<float> inner(n), outer(n);
    for (int i = 0; i < n; ++i) {
        inner[i] = method == CreaseMethod::uniform ? child_sharpness(ring.sharpness[i])
                                                   : child_sharpness_chaikin(ring.sharpness[i], ring.sharpness);
        outer[i] = method == CreaseMethod::uniform ? inner[i] : ring.outer_child[i];
    }
    const float child_vertex = child_sharpness(ring.vertex_sharpness);

    std::vector<Vec3d> finer(p.size());
    const VertexBlend blend = vertex_blend(ring.sharpness, ring.vertex_sharpness, inner, child_vertex);
    finer[0] = (blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex) * p[0];
    if (blend.crease.weight > 0)
        finer[0] +=
            blend.crease.weight * k_crease_vertex_mask.neighbour * (edge(blend.crease.a) + edge(blend.crease.b));
    if (blend.smooth > 0) {
        const RingMask mask = quads ? CatmullClark::vertex_mask_quads(n) : Loop::vertex_mask(n);
        Vec3d edges(0), corners(0);
        for (int i = 0; i < n; ++i) edges += edge(i);
        for (int i = 0; quads && i < faces; ++i) corners += face(i);
        finer[0] += blend.smooth * (mask.vertex * p[0] + mask.edge * edges + mask.face * corners);
    }
    for (int i = 0; i < n; ++i) {
        const double crease = edge_crease_weight(ring.sharpness[i], inner[i], outer[i]);
        Vec3d q = crease * 0.5 * (p[0] + edge(i));
        if (crease != 1) {
            const Vec3d smooth =
                quads ? CatmullClark::edge_end_quads * (p[0] + edge(i)) +
                            CatmullClark::edge_side_quads * (edge(i - 1) + edge(i + 1) + face(i - 1) + face(i))
                      : Loop::edge_end * (p[0] + edge(i)) + Loop::edge_opposite * (edge(i - 1) + edge(i + 1));
            q += (1 - crease) * smooth;
        }
        finer[1 + stride * i] = q;
    }
    for (int i = 0; quads && i < faces; ++i) finer[2 + 2 * i] = 0.25 * (p[0] + edge(i) + edge(i + 1) + face(i));

    if (method == CreaseMethod::chaikin)
        for (int i = 0; i < n; ++i) ring.outer_child[i] = half_beside(method, inner[i], outer[i]);
    ring.points = std::move(finer);
    ring.sharpness = std::move(inner);
    ring.vertex_sharpness = child_vertex;
}

/// Follows finite sharpness until it is gone. The masks of the ring then, and its shape, the calling thread's.
std::pair<const RingLimit&, const RingShape&> masks(SchemeKind scheme, CreaseMethod method, VertexRing& ring) {
    while (any_semi_sharp(ring)) {
        // A semi-sharp vertex among smooth edges comes without an array of zeros.
        const int n = ring.faces + (ring.boundary ? 1 : 0);
        if (ring.sharpness.empty()) {
            ring.sharpness.assign(n, 0.0f);
            ring.outer_child.assign(n, 0.0f);
            if (ring.boundary) ring.sharpness.front() = ring.sharpness.back() = k_sharpness_infinity;
        }
        refine_ring(scheme, method, ring);
    }
    thread_local RingShape shape;
    shape.faces = ring.faces;
    shape.boundary = ring.boundary;
    shape.corner = is_sharp(ring.vertex_sharpness);
    shape.sharp.clear();
    if (std::any_of(ring.sharpness.begin(), ring.sharpness.end(), is_sharp))
        for (const float s : ring.sharpness) shape.sharp.push_back(is_sharp(s));
    return {ring_limit(scheme, shape), shape};
}

}  // namespace

Vec3d limit_position(SchemeKind scheme, CreaseMethod method, VertexRing& ring) {
    const RingLimit& limit = masks(scheme, method, ring).first;
    Vec3d result(0);
    const Vec3d& centre = ring.points[0];
    for (std::size_t i = 1; i < ring.points.size(); ++i) result += limit.position[i] * (ring.points[i] - centre);
    return result + centre;
}

LimitPoint limit_point(SchemeKind scheme, CreaseMethod method, VertexRing& ring) {
    const auto& [limit, shape] = masks(scheme, method, ring);
    LimitPoint result;
    // Differences from the vertex: weights sum to one or zero, and an origin far away must not cost digits.
    const Vec3d& centre = ring.points[0];
    for (std::size_t i = 1; i < ring.points.size(); ++i) {
        const Vec3d d = ring.points[i] - centre;
        result.position += limit.position[i] * d;
        result.tangent1 += limit.tangent1[i] * d;
        result.tangent2 += limit.tangent2[i] * d;
    }
    result.position += centre;
    result.normal = limit_normal(scheme, shape, limit, ring.points);
    result.has_tangent_plane = limit.has_tangent_plane;
    return result;
}

}  // namespace tetrakis
