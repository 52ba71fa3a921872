#include "site_stencils.hpp"

#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/catmull_clark.hpp"
#include "../../schemes/rules/loop.hpp"

namespace tetrakis::detail {

void vertex_rule_stencil(SchemeKind scheme, const KeyRing& ring, std::vector<StencilEntry>& out) {
    const bool quads = scheme == SchemeKind::catmull_clark;
    const int stride = quads ? 2 : 1, n = ring.faces + (ring.boundary ? 1 : 0);
    VertexBlend blend;
    if (!ring.sharpness.empty() || is_sharp(ring.vertex_sharpness))
        blend = vertex_blend(ring.sharpness, ring.vertex_sharpness, ring.child, ring.child_vertex_sharpness);
    double centre = blend.corner + blend.crease.weight * k_crease_vertex_mask.vertex;
    if (blend.crease.weight > 0) {
        const double w = blend.crease.weight * k_crease_vertex_mask.neighbour;
        out.push_back({ring.keys[1 + stride * blend.crease.a], w});
        out.push_back({ring.keys[1 + stride * blend.crease.b], w});
    }
    if (blend.smooth > 0) {
        const RingMask mask = quads ? CatmullClark::vertex_mask_quads(n) : Loop::vertex_mask(n);
        centre += blend.smooth * mask.vertex;
        for (int i = 0; i < n; ++i) out.push_back({ring.keys[1 + stride * i], blend.smooth * mask.edge});
        for (int i = 0; quads && i < ring.faces; ++i) out.push_back({ring.keys[2 + 2 * i], blend.smooth * mask.face});
    }
    out.push_back({ring.keys[0], centre});
}

void edge_point_tags(const EdgeSharpness& sharpness, HalfedgeId h, int level, std::uint64_t i, int before, int after,
                     int edges, KeyRing& ring) {
    const float a = sharpness.piece(h, level, i - 1), b = sharpness.piece(h, level, i);
    if (!is_sharp(a) && !is_sharp(b)) return;
    for (auto* values : {&ring.sharpness, &ring.child, &ring.outer_child}) values->assign(edges, 0.0f);
    ring.sharpness[before] = a;
    ring.sharpness[after] = b;
    ring.child[before] = sharpness.piece(h, level + 1, 2 * i - 1);
    ring.child[after] = sharpness.piece(h, level + 1, 2 * i);
    ring.outer_child[before] = sharpness.piece(h, level + 1, 2 * i - 2);
    ring.outer_child[after] = sharpness.piece(h, level + 1, 2 * i + 1);
}

void control_vertex_tags(const ControlMesh& mesh, const EdgeSharpness& sharpness, VertexId v, int level,
                         KeyRing& ring) {
    ring.vertex_sharpness = sharpness.vertex(v, level);
    ring.child_vertex_sharpness = sharpness.vertex(v, level + 1);
    bool sharp = is_sharp(ring.vertex_sharpness);
    const HalfedgeId start = mesh.vertex_halfedge(v);
    HalfedgeId h = start;
    do {
        ring.sharpness.push_back(sharpness.at_origin(h, level));
        ring.child.push_back(sharpness.at_origin(h, level + 1));
        ring.outer_child.push_back(sharpness.piece(h, level + 1, 1));
        sharp |= is_sharp(ring.sharpness.back());
        h = mesh.ccw_outgoing(h);
    } while (h.valid() && h != start);
    if (!h.valid())  // the last edge of a boundary vertex
        for (auto* values : {&ring.sharpness, &ring.child, &ring.outer_child}) values->push_back(k_sharpness_infinity);
    if (sharp) return;
    ring.sharpness.clear();
    ring.child.clear();
    ring.outer_child.clear();
}

}  // namespace tetrakis::detail
