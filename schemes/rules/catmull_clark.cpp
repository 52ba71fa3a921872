#include "catmull_clark.hpp"

#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace tetrakis {

RingMask CatmullClark::vertex_mask(int valence) {
    const double n = valence;
    return {.vertex = (n - 2) / n, .edge = 1 / (n * n), .face = 1 / (n * n)};
}

RingMask CatmullClark::limit_mask(int valence) {
    const double n = valence;
    return {.vertex = n / (n + 5), .edge = 4 / (n * (n + 5)), .face = 1 / (n * (n + 5))};
}

double CatmullClark::mode_eigenvalue(double angle) {
    const double c = std::cos(angle);
    return (5 + c + std::sqrt(std::max(0.0, (1 + c) * (9 + c)))) / 16;
}

double CatmullClark::tangent_edge_factor(double angle) {
    // From the column of a face weight: A / 16 + 1 / 4 = lambda.
    return 16 * mode_eigenvalue(angle) - 4;
}

ClosedMasks CatmullClark::ring_closed_masks(int n, const RingMask& limit) {
    const double angle = 2 * std::numbers::pi / n;
    return tetrakis::ring_closed_masks(n, limit, tangent_edge_factor(angle), 1);
}

namespace {

using std::numbers::pi;

// Most quads beside a crease with which the plain rule still has a tangent plane.
constexpr int k_plain_quads = 3;

/// Largest eigenvalue of the ring's first sine mode at a corner with K quads and theta = alpha / K.
double corner_mode(int K, double theta) {
    const double phi = pi / K, e = 3.0 / 8 - std::cos(theta) / 4 + std::cos(phi) / 8;
    const double trace = e + 0.25, determinant = e / 4 - (2 + 2 * std::cos(phi)) / 64;
    return trace / 2 + std::sqrt(std::max(0.0, trace * trace / 4 - determinant));
}

StencilRow vertex_row(const RuleMesh& mesh, int v, const RuleMesh::Ring& ring, const RuleOptions& options) {
    const int n = ring.edges();
    StencilRow row;
    if (n != 4 && (options.catmull_clark_beta || options.catmull_clark_gamma)) {
        const double beta = options.catmull_clark_beta.value_or(3.0 / (2 * n));
        const double gamma = options.catmull_clark_gamma.value_or(1.0 / (4 * n));
        bool quads = true;
        for (const int h : ring.halfedge) quads = quads && mesh.face_size(mesh.face(h)) == 4;
        if (!quads)
            throw std::invalid_argument("other Catmull-Clark weights need quads; refine once without them first");
        if (!catmull_clark_weights_admissible(n, beta, gamma)) {
            const auto corners = catmull_clark_weight_range(n);
            char text[240];
            std::snprintf(
                text, sizeof text,
                "Catmull-Clark weights beta %.6g, gamma %.6g leave no tangent plane at valence %d; they must lie "
                "inside the triangle (%.6g, %.6g), (%.6g, %.6g), (%.6g, %.6g)",
                beta, gamma, n, corners[0][0], corners[0][1], corners[1][0], corners[1][1], corners[2][0],
                corners[2][1]);
            throw std::invalid_argument(text);
        }
        row.add(v, 1 - beta - gamma);
        for (int i = 0; i < n; ++i) {
            row.add(ring.neighbour[i], beta / n);
            row.add(mesh.origin(mesh.prev(mesh.prev(ring.halfedge[i]))), gamma / n);
        }
        return row;
    }
    const RingMask mask = CatmullClark::vertex_mask(n);
    row.add(v, mask.vertex);
    for (const int e : ring.neighbour) row.add(e, mask.edge);
    for (const int h : ring.halfedge) row.add(detail::face_mean(mesh, mesh.face(h)), mask.face);
    return row;
}

StencilRow smooth_edge_row(const RuleMesh& mesh, int h, const RuleOptions& options) {
    const int u = mesh.origin(h), v = mesh.target(h);
    StencilRow row{{u, CatmullClark::edge_end}, {v, CatmullClark::edge_end}};
    for (const int side : {h, mesh.twin(h)})
        row.add(detail::face_mean(mesh, mesh.face(side)), CatmullClark::edge_face_point);
    const auto bend = detail::bend_at(mesh, h, options, k_plain_quads);
    if (!bend) return row;
    row.add(mesh.origin(bend->out), std::cos(bend->theta) / 4);
    row.add(mesh.target(bend->out), -std::cos(bend->theta) / 4);
    return detail::flattened_edge(row, mesh, *bend, corner_mode);
}

StencilRow face_row(const RuleMesh& mesh, int f, const RuleOptions& options) {
    StencilRow row = detail::face_mean(mesh, f);
    if (mesh.face_size(f) != 4 || !detail::may_have_angles(mesh, options)) return row;
    for (int h = mesh.face_begin(f); h < mesh.face_begin(f) + 4; ++h) {
        const double angle = detail::sector_angle(mesh, h, options);
        if (angle <= pi) continue;
        if (mesh.rule(mesh.origin(h)) != VertexRule::corner) continue;
        const RuleMesh::Ring sector =
            mesh.sector(mesh.sharp(h) && !mesh.sharp(mesh.prev(h)) ? mesh.twin(mesh.prev(h)) : h);
        if (sector.closed || sector.faces() < 2) continue;
        const int i =
            static_cast<int>(std::find(sector.halfedge.begin(), sector.halfedge.end(), h) - sector.halfedge.begin());
        return detail::flattened_face(row, mesh.origin(h), sector, i, angle,
                                      corner_mode(sector.faces(), angle / sector.faces()));
    }
    return row;
}

}  // namespace

RuleStep catmull_clark_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::check_corner_angle(options);
    const detail::HalfSharpness halves(mesh, options.chaikin_creases);
    return detail::split_polygons(
        mesh, halves, options.runner,
        [&](int v) {
            return detail::blended_vertex_row(
                mesh, v, halves, [&](const RuleMesh::Ring& ring) { return vertex_row(mesh, v, ring, options); });
        },
        [&](int h) {
            return detail::blended_edge_row(halves.crease_weight(h), detail::edge_midpoint(mesh, h),
                                            [&] { return smooth_edge_row(mesh, h, options); });
        },
        [&](int f) { return face_row(mesh, f, options); });
}

std::array<std::array<double, 2>, 3> catmull_clark_weight_range(int valence) {
    const double lambda = CatmullClark::mode_eigenvalue(2 * pi / valence), square = lambda * lambda;
    const auto at = [](double t, double d) {
        const double beta = (1 - 16 * d) / 2;
        return std::array{beta, 0.75 - t - beta};
    };
    return {at(2 * lambda, square), at(-2 * lambda, square), at(0, -square)};
}

bool catmull_clark_weights_admissible(int valence, double beta, double gamma) {
    const double lambda = CatmullClark::mode_eigenvalue(2 * pi / valence);
    const double t = 0.75 - beta - gamma, d = (1 - 2 * beta) / 16;
    return std::abs(d) < lambda * lambda && std::abs(t) < lambda + d / lambda;
}

ClosedMasks catmull_clark_closed_masks(const FanShape& shape, const RuleOptions& options) {
    if (shape.dart || (shape.corner && !shape.boundary)) return {};
    const int n = shape.faces;
    if (!shape.boundary) {
        RingMask limit = CatmullClark::limit_mask(n);
        if (n != 4 && (options.catmull_clark_beta || options.catmull_clark_gamma)) {
            // Left eigenvector of the symmetric part: totals (c, e, f) with c (b + g) = 3/8 e + f / 4 and
            // f = g c + e / 8 + f / 4.
            const double b = options.catmull_clark_beta.value_or(3.0 / (2 * n));
            const double g = options.catmull_clark_gamma.value_or(1.0 / (4 * n));
            const double e = (b + 2 * g / 3) / (3.0 / 8 + 1.0 / 24), f = (4 * g + e / 2) / 3, sum = 1 + e + f;
            limit = {.vertex = 1 / sum, .edge = e / sum / n, .face = f / sum / n};
        }
        return CatmullClark::ring_closed_masks(n, limit);
    }
    if (shape.corner) return corner_closed_masks(n, n == 1 || shape.angle > 0 || options.corner_angle > 0);
    ClosedMasks masks = crease_closed_masks(n);
    if (n > 1 && options.edge_beside_crease == EdgeBesideCrease::brief) return masks;
    const double theta = pi / n, c = std::cos(theta);
    AcrossMask across;
    if (n > 1 && options.edge_beside_crease == EdgeBesideCrease::plain) {
        const double lambda = CatmullClark::mode_eigenvalue(theta), A = CatmullClark::tangent_edge_factor(theta);
        across = AcrossMask::solve(lambda, lambda * std::sin(theta),
                                   (CatmullClark::edge_end_quads * A + 0.5) / std::tan(theta / 2), A);
    } else if (n > 1) {
        const double R = (1 + c) / std::sin(theta);
        across = {.vertex = 4 * R * (c - 1), .end = -R * (1 + 2 * c), .inner = 4};
    }
    masks.tangent2 = across.mask(n);
    for (int i = 0; n > 1 && i < n; ++i)
        masks.tangent2.emplace_back(FanLabel{i, 1, 1}, std::sin(i * theta) + std::sin((i + 1) * theta));
    return masks;
}

namespace detail {

extern constinit const SchemeInfo catmull_clark_scheme{
    .name = "catmull-clark",
    .title = "Catmull, Clark 1978",
    .refinement = Refinement::face_split,
    .family = MeshFamily::quads,
    .smoothness = "C2",
    .generation = "bi-3",
    .lattice = FanLattice::quads,
    .rings = 2,
    .step = catmull_clark_step,
    .closed_masks = catmull_clark_closed_masks,
    .notes = "any polygons; boundary, crease, corner, dart, semi-sharp; C1 edge rule, other weights beta, gamma",
    .pieces = SurfacePieces::bicubic,
    .one_ring_limits = true,
    .takes_corner_angles = true,
};

}  // namespace detail
}  // namespace tetrakis
