#include "../../schemes/core/sharpness.hpp"
#include "../../schemes/rules/loop.hpp"
#include "site_stencils.hpp"

namespace tetrakis::detail {

TriangleStencils::TriangleStencils(const ControlMesh& mesh)
    : mesh_(&mesh), sharpness_(mesh), frames_(mesh.halfedge_count()) {
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i);
        frames_[i] = {mesh.vertex_halfedge(mesh.origin(h)).value, mesh.edge_halfedge(mesh.edge(h)).value};
    }
}

std::uint32_t TriangleStencils::base_number(VertexKey key) const { return mesh_->origin(HalfedgeId(key.root)).value; }

VertexKey TriangleStencils::canonical(VertexKey at, int level) const {
    const std::uint32_t n = std::uint32_t{1} << level, z = n - at.x - at.y, h = at.root;
    // The half-edges of face f are 3 f, 3 f + 1 and 3 f + 2.
    const std::uint32_t side = h % 3, next = side == 2 ? h - 2 : h + 1, prev = side == 0 ? h + 2 : h - 1;
    const auto vertex = [&](std::uint32_t out) { return VertexKey{frames_[out].vertex, 0, 0}; };
    const auto edge = [&](std::uint32_t along, std::uint32_t distance) {
        const std::uint32_t first = frames_[along].edge;
        return VertexKey{first, first == along ? distance : n - distance, 0};
    };
    // Weights of the corners: z at origin(h), x at its target, y at the third.
    if (at.y == 0) return at.x == 0 ? vertex(h) : z == 0 ? vertex(next) : edge(h, at.x);
    if (at.x == 0) return z == 0 ? vertex(prev) : edge(prev, z);
    if (z == 0) return edge(next, at.y);
    if (side == 0) return at;
    // In the frame of next(h), x weighs the third corner and y the origin of h.
    return side == 2 ? VertexKey{next, at.y, z} : VertexKey{prev, z, at.x};
}

void TriangleStencils::ring(VertexKey key, int level, KeyRing& ring) const {
    const std::uint32_t n = std::uint32_t{1} << level, x = key.x, y = key.y;
    const HalfedgeId h(key.root);
    ring.clear();
    ring.faces = 6;
    const bool inside = x != 0 && y != 0;  // the root is then its face's first, and what is inside, too, has that frame
    const auto add = [&](HalfedgeId root, std::uint32_t px, std::uint32_t py) {
        const VertexKey at{root.value, px, py};
        ring.keys.push_back(inside && px != 0 && py != 0 && px + py < n ? at : canonical(at, level));
    };
    ring.keys.push_back(key);
    if (x == 0 && y == 0) {
        ring.faces = 0;
        HalfedgeId out = h;
        for (;;) {
            add(out, 1, 0);
            ++ring.faces;
            const HalfedgeId next = mesh_->ccw_outgoing(out);
            if (next == h) break;
            if (!next.valid()) {
                ring.boundary = true;
                add(out, 0, 1);
                break;
            }
            out = next;
        }
        control_vertex_tags(*mesh_, sharpness_, mesh_->origin(h), level, ring);
    } else if (y == 0) {
        const HalfedgeId t = mesh_->twin(h);
        add(h, x + 1, 0);
        add(h, x, 1);
        add(h, x - 1, 1);
        add(h, x - 1, 0);
        ring.boundary = !t.valid();
        if (t.valid()) {
            add(t, n - x, 1);
            add(t, n - x - 1, 1);
        }
        ring.faces = t.valid() ? 6 : 3;
        edge_point_tags(sharpness_, h, level, x, 3, 0, t.valid() ? 6 : 4, ring);
    } else {
        add(h, x + 1, y);
        add(h, x, y + 1);
        add(h, x - 1, y + 1);
        add(h, x - 1, y);
        add(h, x, y - 1);
        add(h, x + 1, y - 1);
    }
}

void TriangleStencils::stencil(VertexKey key, int level, KeyRing& scratch, std::vector<StencilEntry>& out) const {
    const HalfedgeId h(key.root);
    const std::uint32_t a = key.x / 2, b = key.y / 2, n = std::uint32_t{1} << (level - 1);
    const bool x_odd = (key.x & 1) != 0, y_odd = (key.y & 1) != 0;
    const bool inside = key.x != 0 && key.y != 0;
    const auto add = [&](HalfedgeId root, std::uint32_t x, std::uint32_t y, double w) {
        const VertexKey at{root.value, x, y};
        out.push_back({inside && x != 0 && y != 0 && x + y < n ? at : canonical(at, level - 1), w});
    };
    if (!x_odd && !y_odd) {
        ring({key.root, a, b}, level - 1, scratch);
        vertex_rule_stencil(scheme, scratch, out);
        return;
    }
    double crease = 0;
    HalfedgeId twin;
    if (key.y == 0) {
        twin = mesh_->twin(h);
        crease = twin.valid() ? edge_crease_weight(sharpness_.piece(h, level - 1, a), sharpness_.piece(h, level, 2 * a),
                                                   sharpness_.piece(h, level, 2 * a + 1))
                              : 1;
    }
    const double end = crease * 0.5 + (1 - crease) * Loop::edge_end;
    const double opposite = (1 - crease) * Loop::edge_opposite;
    if (x_odd && y_odd) {
        add(h, a + 1, b, end);
        add(h, a, b + 1, end);
        add(h, a, b, opposite);
        add(h, a + 1, b + 1, opposite);
    } else if (x_odd) {
        add(h, a, b, end);
        add(h, a + 1, b, end);
        if (crease == 1) return;
        add(h, a, b + 1, opposite);
        if (key.y == 0)
            add(twin, n - a - 1, 1, opposite);
        else
            add(h, a + 1, b - 1, opposite);
    } else {
        add(h, a, b, end);
        add(h, a, b + 1, end);
        add(h, a + 1, b, opposite);
        add(h, a - 1, b + 1, opposite);
    }
}

}  // namespace tetrakis::detail
