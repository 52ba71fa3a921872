#include "four_eight.hpp"

#include "../core/masks.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"

#include <cstdlib>

namespace tetrakis {

namespace {

/// The rule of a vertex in a bisection that cuts boundary edges; empty for smooth vertices and darts.
StencilRow crease_vertex_row(const RuleMesh& mesh, int v) {
    const RuleMesh::Ring ring = mesh.ring(v);
    const VertexRule rule = vertex_rule(ring.sharpness, mesh.vertex_sharpness(v));
    if (ring.faces() == 0 || rule == VertexRule::corner) return {{v, 1}};
    if (rule != VertexRule::crease) return {};
    StencilRow row{{v, k_crease_vertex_mask.vertex}};
    for (const int e : mesh.sharp_neighbours(v)) row.add(e, k_crease_vertex_mask.neighbour);
    return row;
}

StencilRow midpoint(const RuleMesh& mesh, int h) { return {{mesh.origin(h), 0.5}, {mesh.target(h), 0.5}}; }

}  // namespace

RuleStep four_eight_step(const RuleMesh& mesh, const RuleOptions& options) {
    if (!mesh.all_faces_have(4)) return four_eight_first_step(mesh, options);
    const BlockRunner* runner = options.runner;
    // After the first bisection: old vertices, and the blocks' points.
    StencilTable vertex, crease;
    crease.push_rows(runner, mesh.vertex_count(), [&](int v) { return crease_vertex_row(mesh, v); });
    vertex.push_rows(runner, mesh.vertex_count(), [&](int v) -> StencilRow {
        if (!crease.points(v).empty()) return {{v, 1}};
        const RuleMesh::Ring ring = mesh.ring(v);
        StencilRow row{{v, 0.5}};
        for (const int e : ring.neighbour) row.add(e, 0.5 / ring.edges());
        return row;
    });
    const auto add_block = [&](int f, double weight, StencilRow& row) {
        for (const int v : mesh.corners(f)) row.add(v, weight / 4);
    };
    return detail::split_polygons(
        mesh, runner,
        [&](int v) {
            if (!crease.points(v).empty()) return crease.row(v);
            const RuleMesh::Ring ring = mesh.ring(v);
            StencilRow row;
            vertex.add_row(v, 0.5, row);
            for (const int h : ring.halfedge) add_block(mesh.face(h), 0.5 / ring.faces(), row);
            return row;
        },
        [&](int h) {
            if (mesh.sharp(h)) return midpoint(mesh, h);
            StencilRow row;
            for (const int v : {mesh.origin(h), mesh.target(h)}) vertex.add_row(v, 0.25, row);
            for (const int side : {h, mesh.twin(h)}) add_block(mesh.face(side), 0.25, row);
            return row;
        },
        [&](int f) {
            StencilRow row;
            add_block(f, 0.5, row);
            for (const int v : mesh.corners(f)) vertex.add_row(v, 0.125, row);
            return row;
        });
}

RuleStep four_eight_first_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::split_polygons(
        mesh, options.runner,
        [&](int v) {
            StencilRow row = crease_vertex_row(mesh, v);
            if (!row.terms.empty()) return row;
            const RuleMesh::Ring ring = mesh.ring(v);
            row.add(v, 0.5);
            for (const int h : ring.halfedge) row.add(detail::face_mean(mesh, mesh.face(h)), 0.5 / ring.faces());
            return row;
        },
        [&](int h) {
            if (mesh.sharp(h)) return midpoint(mesh, h);
            StencilRow row{{mesh.origin(h), 0.25}, {mesh.target(h), 0.25}};
            for (const int side : {h, mesh.twin(h)}) row.add(detail::face_mean(mesh, mesh.face(side)), 0.25);
            return row;
        },
        // The centroid of its corners' mean and itself, which is that mean.
        [&](int f) { return detail::face_mean(mesh, f); });
}

ClosedMasks four_eight_closed_masks(const FanShape& shape, const RuleOptions&) {
    ClosedMasks masks;
    const int n = shape.faces;
    if (shape.dart || (shape.corner && !shape.boundary)) return masks;
    if (shape.corner) return {.limit = {{{}, 1}}};
    if (shape.boundary) return crease_closed_masks(n);
    masks.limit.emplace_back(FanLabel{}, 7.0 / 24);
    for (int i = 0; i < n; ++i) {
        masks.limit.emplace_back(FanLabel{i, 1, 0}, 59.0 / (120 * n));
        masks.limit.emplace_back(FanLabel{i, 1, 1}, 11.0 / (60 * n));
        masks.limit.emplace_back(FanLabel{i, 2, 0}, 1.0 / (40 * n));
        masks.limit.emplace_back(FanLabel{i, 2, 1}, 1.0 / (240 * n));
        masks.limit.emplace_back(FanLabel{i, 1, 2}, 1.0 / (240 * n));
    }
    if (n != 4) return masks;
    masks.lambda1 = masks.lambda2 = 0.5;
    // Odd in x, even in y; by place in the first quadrant.
    constexpr double weight[3][3] = {{0, 0, 0}, {104, 46, 2}, {14, 3, 0}};
    for (int x = -2; x <= 2; ++x)
        for (int y = -2; y <= 2; ++y) {
            const double w = weight[std::abs(x)][std::abs(y)] * (x < 0 ? -1 : 1);
            if (w == 0) continue;
            // Quadrants are sectors: (x, y) -> steps along the sector's first and second ray.
            const auto label = [](int p, int q) {
                if (p > 0 && q >= 0) return FanLabel{0, p, q};
                if (p <= 0 && q > 0) return FanLabel{1, q, -p};
                if (p < 0) return FanLabel{2, -p, -q};
                return FanLabel{3, -q, p};
            };
            masks.tangent1.emplace_back(label(x, y), w);
            masks.tangent2.emplace_back(label(-y, x), w);
        }
    return masks;
}

namespace detail {

extern constinit const SchemeInfo four_eight_scheme{
    .name = "4-8",
    .title = "4-8, Velho, Zorin 2001",
    .refinement = Refinement::bisection,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C4",
    .reproduction = 1,
    .generation = "5",
    .lattice = FanLattice::quads,
    .rings = 2,
    .rule_rings = 1,
    .sees_rings = false,
    .step = four_eight_step,
    .closed_masks = four_eight_closed_masks,
    .notes =
        "quads as blocks, two bisections at once; other polygons through their tetrakis mesh; boundary, crease, corner",
    .first_step = four_eight_first_step,
};

}  // namespace detail
}  // namespace tetrakis
