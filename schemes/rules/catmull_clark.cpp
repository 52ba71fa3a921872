#include "catmull_clark.hpp"

#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"
#include "ring_limit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>

namespace tetrakis {

RingMask CatmullClark::vertex_mask(int valence) {
    const double n = valence;
    return {.vertex = (n - 2) / n, .edge = 1 / (n * n), .face = 1 / (n * n)};
}

RingMask CatmullClark::vertex_mask_quads(int valence) {
    const double n = valence;
    return {.vertex = 1 - 7 / (4 * n), .edge = 3 / (2 * n * n), .face = 1 / (4 * n * n)};
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

namespace {

using std::numbers::pi;

// Most quads beside a crease with which the plain rule still has a tangent plane.
constexpr int k_plain_quads = 3;

/// A corner or crease end of a smooth edge that bends its rule, and the angle per face there.
struct Bend {
    int out;  ///< half-edge from that end
    double theta;
    double corner_angle;  ///< 0 on creases
};

std::optional<Bend> bend_at(const RuleMesh& mesh, int h, const RuleOptions& options) {
    // A semi-sharp edge is one of a crease's own edges, not beside it.
    if (mesh.sharp(h) ||
        (options.edge_beside_crease == EdgeBesideCrease::plain && !detail::may_have_angles(mesh, options)))
        return std::nullopt;
    const auto bends = [&](int out) {
        const VertexRule rule = mesh.rule(mesh.origin(out));
        return rule == VertexRule::crease ||
               (rule == VertexRule::corner && detail::sector_angle(mesh, out, options) > 0);
    };
    const bool u = bends(h), v = bends(mesh.twin(h));
    if (u == v) return std::nullopt;
    const int out = u ? h : mesh.twin(h);
    const int K = mesh.sector(out).faces();
    if (mesh.rule(mesh.origin(out)) == VertexRule::corner) {
        const double angle = detail::sector_angle(mesh, out, options);
        return Bend{out, angle / K, angle};
    }
    if (options.edge_beside_crease == EdgeBesideCrease::plain) return std::nullopt;
    if (options.edge_beside_crease == EdgeBesideCrease::cosine) return Bend{out, pi / K, 0};
    if (K <= k_plain_quads) return std::nullopt;
    return Bend{out, 0, 0};
}

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
    const auto bend = bend_at(mesh, h, options);
    if (!bend) return row;
    const int c = mesh.origin(bend->out), e = mesh.target(bend->out);
    row.add(c, std::cos(bend->theta) / 4);
    row.add(e, -std::cos(bend->theta) / 4);
    if (bend->corner_angle <= pi) return row;
    const RuleMesh::Ring sector = mesh.sector(bend->out);
    if (sector.closed) return row;
    return detail::flattened(row, c, sector, sector.position(e), bend->corner_angle,
                             corner_mode(sector.faces(), bend->theta));
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
        [&](int v) -> StencilRow {
            const RuleMesh::Ring ring = mesh.ring(v);
            if (ring.faces() == 0) return {{v, 1}};
            return detail::blended_vertex_row(mesh, v, ring, halves,
                                              [&] { return vertex_row(mesh, v, ring, options); });
        },
        [&](int h) {
            const double crease = halves.crease_weight(h);
            StencilRow row;
            if (crease != 0) row.add(StencilRow{{mesh.origin(h), 0.5}, {mesh.target(h), 0.5}}, crease);
            if (crease != 1) row.add(smooth_edge_row(mesh, h, options), 1 - crease);
            return row;
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
    ClosedMasks masks;
    const int n = shape.faces;
    const auto edge = [](int i) { return FanLabel{i, 1, 0}; };
    const auto face = [](int i) { return FanLabel{i, 1, 1}; };
    if (shape.dart) return masks;
    if (!shape.boundary) {
        if (shape.corner) return masks;
        const double angle = 2 * pi / n, A = CatmullClark::tangent_edge_factor(angle);
        if (n != 4 && (options.catmull_clark_beta || options.catmull_clark_gamma)) {
            // Left eigenvector of the symmetric part: totals (c, e, f) with c (b + g) = 3/8 e + f / 4 and
            // f = g c + e / 8 + f / 4.
            const double b = options.catmull_clark_beta.value_or(3.0 / (2 * n));
            const double g = options.catmull_clark_gamma.value_or(1.0 / (4 * n));
            const double e = (b + 2 * g / 3) / (3.0 / 8 + 1.0 / 24), f = (4 * g + e / 2) / 3, sum = 1 + e + f;
            masks.limit.emplace_back(FanLabel{}, 1 / sum);
            for (int i = 0; i < n; ++i) {
                masks.limit.emplace_back(edge(i), e / sum / n);
                masks.limit.emplace_back(face(i), f / sum / n);
            }
        } else {
            const RingMask limit = CatmullClark::limit_mask(n);
            masks.limit.emplace_back(FanLabel{}, limit.vertex);
            for (int i = 0; i < n; ++i) {
                masks.limit.emplace_back(edge(i), limit.edge);
                masks.limit.emplace_back(face(i), limit.face);
            }
        }
        masks.lambda1 = masks.lambda2 = CatmullClark::mode_eigenvalue(angle);
        for (int i = 0; n > 2 && i < n; ++i) {
            masks.tangent1.emplace_back(edge(i), A * std::cos(i * angle));
            masks.tangent1.emplace_back(face(i), std::cos(i * angle) + std::cos((i + 1) * angle));
            masks.tangent2.emplace_back(edge(i), A * std::sin(i * angle));
            masks.tangent2.emplace_back(face(i), std::sin(i * angle) + std::sin((i + 1) * angle));
        }
        return masks;
    }
    const int K = n;
    if (shape.corner) {
        masks.limit = {{{}, 1}};
        if (K == 1 || shape.angle > 0 || options.corner_angle > 0) {
            masks.lambda1 = masks.lambda2 = 0.5;
            masks.tangent1 = {{{}, -1}, {edge(0), 1}};
            masks.tangent2 = {{{}, -1}, {edge(K), 1}};
        }
        return masks;
    }
    masks = crease_closed_masks(K);
    if (K == 1 || options.edge_beside_crease == EdgeBesideCrease::plain) {
        const RingLimit& ring = boundary_ring_limit(SchemeKind::catmull_clark, K);
        masks.lambda2 = ring.lambda2;
        masks.tangent2.emplace_back(FanLabel{}, ring.tangent2[0]);
        for (int i = 0; i <= K; ++i) masks.tangent2.emplace_back(edge(i), ring.tangent2[1 + 2 * i]);
        for (int i = 0; i < K; ++i) masks.tangent2.emplace_back(face(i), ring.tangent2[2 + 2 * i]);
    } else if (options.edge_beside_crease == EdgeBesideCrease::cosine) {
        const double theta = pi / K, c = std::cos(theta), R = (1 + c) / std::sin(theta);
        masks.lambda2 = 0.5;
        masks.tangent2.emplace_back(FanLabel{}, 4 * R * (c - 1));
        for (int i = 0; i <= K; ++i)
            masks.tangent2.emplace_back(edge(i), i == 0 || i == K ? -R * (1 + 2 * c) : 4 * std::sin(i * theta));
        for (int i = 0; i < K; ++i)
            masks.tangent2.emplace_back(face(i), std::sin(i * theta) + std::sin((i + 1) * theta));
    }
    return masks;
}

namespace detail {

extern constinit const SchemeInfo catmull_clark_scheme{
    .name = "catmull-clark",
    .title = "Catmull, Clark 1978",
    .refinement = Refinement::face_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C2",
    .reproduction = 1,
    .generation = "bi-3",
    .lattice = FanLattice::quads,
    .rings = 2,
    .rule_rings = 1,
    .sees_rings = false,
    .step = catmull_clark_step,
    .closed_masks = catmull_clark_closed_masks,
    .notes = "any polygons; boundary, crease, corner, dart, semi-sharp; C1 edge rule, other weights beta, gamma",
    .pieces = SurfacePieces::bicubic,
    .one_ring_limits = true,
    .takes_corner_angles = true,
};

}  // namespace detail
}  // namespace tetrakis
