#include "honeycomb.hpp"

#include "../core/masks.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/corner_weights.hpp"
#include "../parts/face_split.hpp"
#include "dual_schemes.hpp"

namespace tetrakis {

RuleStep honeycomb_step(const RuleMesh& mesh, const RuleOptions& options) {
    RuleStep step;
    const int V = mesh.vertex_count(), H = mesh.halfedge_count();
    std::vector<std::vector<double>> weights;  // by size of face
    for (int f = 0; f < mesh.face_count(); ++f) {
        const int k = mesh.face_size(f);
        if (static_cast<int>(weights.size()) <= k) weights.resize(k + 1);
        if (weights[k].empty()) weights[k] = DooSabin::weights(k);
    }
    const auto add_corner = [&](int h, double weight, StencilRow& row) {
        const int k = mesh.face_size(mesh.face(h));
        for (int i = 0, at = h; i < k; ++i, at = mesh.next(at)) row.add(mesh.origin(at), weight * weights[k][i]);
    };
    step.stencils.push_rows(options.runner, V, [&](int v) -> StencilRow {
        const RuleMesh::Ring ring = mesh.ring(v);
        const VertexRule rule = vertex_rule(ring.sharpness, mesh.vertex_sharpness(v));
        if (ring.faces() == 0 || rule == VertexRule::corner) return {{v, 1}};
        StencilRow row;
        if (rule == VertexRule::crease) {
            row.add(v, 0.75);
            for (const int e : mesh.sharp_neighbours(v)) row.add(e, 0.125);
            return row;
        }
        for (const int h : ring.halfedge) add_corner(h, 1.0 / ring.faces(), row);
        return row;
    });
    step.stencils.push_rows(options.runner, H, [&](int h) {
        StencilRow row;
        add_corner(h, 1, row);
        return row;
    });
    int count = V + H;
    std::vector<int> middle(mesh.edge_count(), RuleMesh::none);
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        if (!mesh.sharp(h)) continue;
        middle[e] = count++;
        step.stencils.push({{mesh.origin(h), 0.5}, {mesh.target(h), 0.5}});
    }
    RuleMesh::Builder faces;
    step.child_halfedge.resize(H);
    for (int h = 0; h < H; ++h) {
        step.child_halfedge[h] = h;
        faces.corner(V + h);
        if (mesh.next(h) > h) continue;
        faces.end_face();
        step.parent_face.push_back(mesh.face(h));
    }
    for (int h = 0; h < H; ++h) {
        const int t = mesh.twin(h), u = mesh.origin(h), v = mesh.target(h);
        if (!mesh.sharp(h)) {
            if (h > t) continue;
            step.parent_face.push_back(mesh.face(h));
            faces.face({u, V + mesh.next(t), V + t, v, V + mesh.next(h), V + h});
            continue;
        }
        const float s = child_sharpness(mesh.sharpness(h));
        faces.corner(u, s);
        faces.corner(middle[mesh.edge(h)], s);
        faces.corner(v);
        faces.corner(V + mesh.next(h));
        faces.corner(V + h);
        faces.end_face();
        step.parent_face.push_back(mesh.face(h));
    }
    step.mesh = RuleMesh(count, std::move(faces), detail::child_vertex_sharpness(mesh, count));
    return step;
}

ClosedMasks honeycomb_closed_masks(const FanShape& shape, const RuleOptions&) {
    return shape.boundary ? crease_closed_masks(1) : detail::corner_weights_closed_masks(shape, 0.5);
}

namespace detail {

extern constinit const SchemeInfo honeycomb_scheme{
    .name = "honeycomb",
    .title = "Honeycomb refinement with Doo-Sabin weights",
    .refinement = Refinement::honeycomb,
    .family = MeshFamily::hexagons,
    .interpolating = false,
    .smoothness = "C0 (more is not proven)",
    .reproduction = 1,
    .generation = "1",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 2,
    .sees_rings = false,
    .step = honeycomb_step,
    .closed_masks = honeycomb_closed_masks,
    .notes = "any polygons; boundary and crease as cubic B-spline",
};

}  // namespace detail
}  // namespace tetrakis
