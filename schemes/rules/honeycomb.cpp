#include "../core/scheme_table.hpp"
#include "../parts/corner_weights.hpp"
#include "../parts/face_split.hpp"
#include "dual_schemes.hpp"

namespace tetrakis {

namespace {

/// The honeycomb refinement (the refinement rule of Dyn, Levin, Liu 1992) with another, approximating mask, as theirs
/// is not stationary. A k-gon gets a k-gon in its middle, an edge becomes a hexagon. Hexagons become four times as
/// many, half as large and not turned. New points: the old vertices, then one per half-edge (the corner at its origin),
/// then one per sharp edge.
///
/// The corners of the middle k-gon have Doo-Sabin's weights, with eigenvalues 1, 1/2 twice and 1/4 for every k. On
/// hexagons they reproduce the plane. The hexagons around a k-gon add an eigenvalue above 1/4, 7/24 (0.2917), so that
/// curvatures are not bounded. An old vertex moves to the mean of the new corners around it. Boundary and crease: cubic
/// B-spline; corner: stays.
RuleStep honeycomb_step(const RuleMesh& mesh, const RuleOptions& options) {
    RuleStep step;
    const int V = mesh.vertex_count(), H = mesh.halfedge_count();
    const detail::FaceWeights weights(mesh, DooSabin::weights);
    step.stencils.push_rows(options.runner, V, [&](int v) {
        const RuleMesh::Ring ring = mesh.ring(v);
        StencilRow row = detail::crease_vertex_row(mesh, v, ring);
        if (!row.terms.empty()) return row;
        for (const int h : ring.halfedge) weights.add_corner(h, 1.0 / ring.faces(), row);
        return row;
    });
    step.stencils.push_rows(options.runner, H, [&](int h) {
        StencilRow row;
        weights.add_corner(h, 1, row);
        return row;
    });
    int count = V + H;
    std::vector<int> middle(mesh.edge_count(), RuleMesh::none);
    for (int e = 0; e < mesh.edge_count(); ++e) {
        const int h = mesh.edge_halfedge(e);
        if (!mesh.sharp(h)) continue;
        middle[e] = count++;
        step.stencils.push(detail::edge_midpoint(mesh, h));
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

/// Masks at the centre of a face, or at a boundary vertex, which gets one more face in each step. Its two faces along
/// the boundary are pentagons, each of which maps to itself.
ClosedMasks honeycomb_closed_masks(const FanShape& shape, const RuleOptions& options) {
    return shape.boundary ? crease_closed_masks(1) : detail::corner_weights_closed_masks(shape, options);
}

}  // namespace

namespace detail {

extern constinit const SchemeInfo honeycomb_scheme{
    .name = "honeycomb",
    .title = "Honeycomb refinement with Doo-Sabin weights",
    .refinement = Refinement::honeycomb,
    .family = MeshFamily::hexagons,
    .smoothness = "C0 (more is not proven)",
    .generation = "1",
    .lattice = FanLattice::dual,
    .rings = 1,
    .step = honeycomb_step,
    .closed_masks = honeycomb_closed_masks,
    .notes = "any polygons; boundary and crease as cubic B-spline",
};

}  // namespace detail
}  // namespace tetrakis
