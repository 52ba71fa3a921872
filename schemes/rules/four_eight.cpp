#include "../core/masks.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"

namespace tetrakis {

namespace {

/// One bisection of blocks of two triangles. A mesh of any polygons has one block per edge, whose corners are the ends
/// of the edge and the centroids of its faces. New points are numbered as for `bilinear`: vertices, edges, faces. A
/// vertex takes 1/2 of the mean of its faces' centroids, a face takes 1/2 of the mean of its corners, and both keep
/// 1/2. An edge's point is the mean of its block's corners.
/// @param corner  corner(vertex): its point before the bisection, as a row
template <class Corner>
RuleStep bisected_step(const RuleMesh& mesh, const BlockRunner* runner, Corner&& corner) {
    return detail::split_polygons(
        mesh, detail::HalfSharpness(mesh), runner,
        [&](int v) {
            const RuleMesh::Ring ring = mesh.ring(v);
            StencilRow row = detail::crease_vertex_row(mesh, v, ring);
            if (!row.terms.empty()) return row;
            row.add(corner(v), 0.5);
            for (const int h : ring.halfedge) row.add(detail::face_mean(mesh, mesh.face(h)), 0.5 / ring.faces());
            return row;
        },
        [&](int h) {
            if (mesh.sharp(h)) return detail::edge_midpoint(mesh, h);
            StencilRow row;
            for (const int v : {mesh.origin(h), mesh.target(h)}) row.add(corner(v), 0.25);
            for (const int side : {h, mesh.twin(h)}) row.add(detail::face_mean(mesh, mesh.face(side)), 0.25);
            return row;
        },
        [&](int f) {
            StencilRow row;
            row.add(detail::face_mean(mesh, f), 0.5);
            for (const int v : mesh.corners(f)) row.add(corner(v), 0.5 / mesh.face_size(f));
            return row;
        });
}

/// The step from any polygons to quads: one bisection of the tetrakis mesh.
RuleStep four_eight_first_step(const RuleMesh& mesh, const RuleOptions& options) {
    return bisected_step(mesh, options.runner, detail::vertex_itself);
}

/// The 4-8 scheme of Velho, Zorin 2001, on quads as blocks of two triangles: two bisections at once split each quad in
/// four. In one bisection, a block's new point is the mean of its four corners; an old vertex keeps 1/2 and takes 1/2
/// of the mean of its neighbours along the blocks' sides. The first bisection does not change boundary and crease
/// edges; in the second they follow the cubic B-spline. A corner stays. Regular: the C4 box spline of e1, e2, e1 + e2,
/// e1 - e2, twice each.
///
/// The rules at extraordinary vertices and boundaries are the direct generalisation. Their eigenstructure is checked by
/// spectral analysis, not against the paper. On a mesh with other faces than quads it is four_eight_first_step().
RuleStep four_eight_step(const RuleMesh& mesh, const RuleOptions& options) {
    if (!mesh.all_faces_have(4)) return four_eight_first_step(mesh, options);
    // Old vertices after the first bisection, which keeps creases; the blocks' points are the centroids of quads.
    StencilTable corners;
    corners.push_rows(options.runner, mesh.vertex_count(), [&](int v) {
        const RuleMesh::Ring ring = mesh.ring(v);
        if (!detail::crease_vertex_row(mesh, v, ring).terms.empty()) return detail::vertex_itself(v);
        return detail::ring_row(v, ring, {.vertex = 0.5, .edge = 0.5 / ring.edges()});
    });
    return bisected_step(mesh, options.runner, [&](int v) { return corners.row(v); });
}

ClosedMasks four_eight_closed_masks(const FanShape& shape, const RuleOptions&) {
    ClosedMasks masks;
    const int n = shape.faces;
    if (shape.dart || (shape.corner && !shape.boundary)) return masks;
    if (shape.corner) return corner_closed_masks(n, false);
    if (shape.boundary) return crease_closed_masks(n);
    masks.limit.emplace_back(FanLabel{}, 7.0 / 24);
    for (int i = 0; i < n; ++i) {
        masks.limit.emplace_back(FanLabel{i, 1, 0}, 59.0 / (120 * n));
        masks.limit.emplace_back(FanLabel{i, 1, 1}, 11.0 / (60 * n));
        masks.limit.emplace_back(FanLabel{i, 2, 0}, 1.0 / (40 * n));
        masks.limit.emplace_back(FanLabel{i, 2, 1}, 1.0 / (240 * n));
        masks.limit.emplace_back(FanLabel{i, 1, 2}, 1.0 / (240 * n));
    }
    return masks;
}

}  // namespace

namespace detail {

extern constinit const SchemeInfo four_eight_scheme{
    .name = "4-8",
    .title = "4-8, Velho, Zorin 2001",
    .refinement = Refinement::bisection,
    .family = MeshFamily::quads,
    .smoothness = "C4",
    .generation = "5",
    .lattice = FanLattice::quads,
    .rings = 2,
    .step = four_eight_step,
    .closed_masks = four_eight_closed_masks,
    .notes =
        "quads as blocks, two bisections at once; other polygons through their tetrakis mesh; boundary, crease, corner",
    .first_step = four_eight_first_step,
};

}  // namespace detail
}  // namespace tetrakis
