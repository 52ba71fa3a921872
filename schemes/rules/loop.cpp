#include "loop.hpp"

#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"
#include "ring_limit.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

double Loop::mode_eigenvalue(double angle) { return 3.0 / 8 + std::cos(angle) / 4; }

double Loop::beta(int valence) {
    if (valence == 6) return 1.0 / 16;  // exactly, where the cosine would round
    const double lambda = mode_eigenvalue(2 * std::numbers::pi / valence);
    return (5.0 / 8 - lambda * lambda) / valence;
}

double Loop::beta_warren(int valence) { return valence > 3 ? 3.0 / (8.0 * valence) : 3.0 / 16; }

RingMask Loop::limit_mask(int valence, double beta) {
    const double chi = 1 / (3 / (8 * beta) + valence);
    return {.vertex = 1 - valence * chi, .edge = chi};
}

namespace {

using std::numbers::pi;

// Most triangles beside a crease with which the plain rule still has a tangent plane; up to there the brief form of the
// C1 rule is the plain rule.
constexpr int k_plain_triangles = 5;
constexpr double k_brief_gamma = 0.25;

bool is_regular_crease(const RuleMesh& mesh, int v) {
    const RuleMesh::Ring ring = mesh.ring(v);
    if (vertex_rule(ring.sharpness, mesh.vertex_sharpness(v)) != VertexRule::crease) return false;
    if (!ring.closed) return ring.faces() == 3;
    std::vector<int> sharp;
    for (int i = 0; i < ring.edges(); ++i)
        if (is_sharp(ring.sharpness[i])) sharp.push_back(i);
    return ring.faces() == 6 && sharp[1] - sharp[0] == 3;
}

}  // namespace

StencilRow detail::loop_crease_edge_row(const RuleMesh& mesh, int h, const RuleOptions& options) {
    const int u = mesh.origin(h), v = mesh.target(h);
    if (options.hoppe_crease && mesh.rule(u) == VertexRule::crease && mesh.rule(v) == VertexRule::crease) {
        const bool ru = is_regular_crease(mesh, u), rv = is_regular_crease(mesh, v);
        if (ru != rv) return {{u, ru ? 5.0 / 8 : 3.0 / 8}, {v, rv ? 5.0 / 8 : 3.0 / 8}};
    }
    return {{u, 0.5}, {v, 0.5}};
}

StencilRow detail::loop_smooth_edge_row(const RuleMesh& mesh, int h, const RuleOptions& options) {
    const int t = mesh.twin(h);
    StencilRow row{{detail::opposite(mesh, h), Loop::edge_opposite}, {detail::opposite(mesh, t), Loop::edge_opposite}};
    // Which end is on a crease, if exactly one is; a corner counts where it has an angle.
    const auto bends = [&](int out) {
        const VertexRule rule = mesh.rule(mesh.origin(out));
        return rule == VertexRule::crease || (rule == VertexRule::corner && sector_angle(mesh, out, options) > 0);
    };
    // A semi-sharp edge is one of a crease's own edges, not beside it.
    if (!mesh.sharp(h) && (options.edge_beside_crease != EdgeBesideCrease::plain || may_have_angles(mesh, options))) {
        const bool u_bends = bends(h), v_bends = bends(t);
        if (u_bends != v_bends) {
            const int out = u_bends ? h : t, c = mesh.origin(out), e = mesh.target(out);
            const RuleMesh::Ring sector = mesh.sector(out);
            const int K = sector.faces();
            const bool corner = mesh.rule(c) == VertexRule::corner;
            const double angle = corner ? sector_angle(mesh, out, options) : pi;
            double gamma = Loop::edge_end;
            if (corner || options.edge_beside_crease == EdgeBesideCrease::cosine)
                gamma = 0.5 - std::cos(angle / K) / 4;
            else if (options.edge_beside_crease == EdgeBesideCrease::brief && K > k_plain_triangles)
                gamma = k_brief_gamma;
            row.add(c, 0.75 - gamma);
            row.add(e, gamma);
            if (!corner || sector.closed || angle <= pi) return row;
            const double theta = angle / K, most = 0.5 + (std::cos(pi / K) - std::cos(theta)) / 4;
            return detail::flattened(row, c, sector, sector.position(e), angle, most);
        }
    }
    row.add(mesh.origin(h), Loop::edge_end);
    row.add(mesh.target(h), Loop::edge_end);
    return row;
}

RuleStep loop_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::need_triangles(mesh, "loop");
    detail::check_corner_angle(options);
    const detail::HalfSharpness halves(mesh, options.chaikin_creases);
    const auto vertex_row = [&](int v) -> StencilRow {
        const RuleMesh::Ring ring = mesh.ring(v);
        if (ring.faces() == 0) return {{v, 1}};
        return detail::blended_vertex_row(mesh, v, ring, halves, [&] {
            const int n = ring.edges();
            const double beta = options.loop_weights == LoopWeights::warren ? Loop::beta_warren(n) : Loop::beta(n);
            StencilRow row{{v, 1 - n * beta}};
            for (const int e : ring.neighbour) row.add(e, beta);
            return row;
        });
    };
    const auto edge_row = [&](int h) {
        const double crease = halves.crease_weight(h);
        StencilRow row;
        if (crease != 0) row.add(detail::loop_crease_edge_row(mesh, h, options), crease);
        if (crease != 1) row.add(detail::loop_smooth_edge_row(mesh, h, options), 1 - crease);
        return row;
    };
    return detail::split_triangles(mesh, halves, options.runner, vertex_row, edge_row);
}

ClosedMasks loop_closed_masks(const FanShape& shape, const RuleOptions& options) {
    ClosedMasks masks;
    const int n = shape.faces;
    const auto edge = [](int i) { return FanLabel{i, 1, 0}; };
    if (shape.dart) return masks;
    if (!shape.boundary) {
        if (shape.corner) return masks;
        const double beta = options.loop_weights == LoopWeights::warren ? Loop::beta_warren(n) : Loop::beta(n);
        return ring_closed_masks(n, Loop::limit_mask(n, beta), Loop::mode_eigenvalue(2 * pi / n));
    }
    const int K = n;
    if (shape.corner) {
        masks.limit = {{{}, 1}};
        // Two triangles: the edge between them goes by 3/8, into the plane of the two sharp ones.
        if (K <= 2 || shape.angle > 0 || options.corner_angle > 0) {
            masks.lambda1 = masks.lambda2 = 0.5;
            masks.tangent1 = {{{}, -1}, {edge(0), 1}};
            masks.tangent2 = {{{}, -1}, {edge(K), 1}};
        }
        return masks;
    }
    const double theta = pi / K;
    masks.lambda1 = 0.5;
    masks.tangent1 = {{edge(0), 1}, {edge(K), -1}};
    const bool extraordinary = K != 3;
    if (options.hoppe_crease && extraordinary) {
        masks.limit = {{{}, 3.0 / 5}, {edge(0), 1.0 / 5}, {edge(K), 1.0 / 5}};
        masks.tangent1.clear();
        if (K >= 4 && options.edge_beside_crease == EdgeBesideCrease::plain) {
            masks.lambda2 = Loop::mode_eigenvalue(theta);
            for (int i = 0; i <= K; ++i)
                masks.tangent2.emplace_back(
                    edge(i), i == 0 || i == K ? std::sin(theta) : (2 * std::cos(theta) - 2) * std::sin(i * theta));
        }
        return masks;
    }
    masks.limit = crease_closed_masks(K).limit;
    if (K == 1 || options.edge_beside_crease == EdgeBesideCrease::plain) {
        // The plain rules' across mask, derived where tessellation uses it.
        const RingLimit& ring = boundary_ring_limit(SchemeKind::loop, K);
        masks.lambda2 = ring.lambda2;
        masks.tangent2.emplace_back(FanLabel{}, ring.tangent2[0]);
        for (int i = 0; i <= K; ++i) masks.tangent2.emplace_back(edge(i), ring.tangent2[1 + i]);
    } else if (options.edge_beside_crease == EdgeBesideCrease::cosine) {
        const double c = std::cos(theta), s = std::sin(theta);
        masks.lambda2 = 0.5;
        masks.tangent2.emplace_back(FanLabel{}, -2 * (1 - c) * s);
        for (int i = 0; i <= K; ++i)
            masks.tangent2.emplace_back(edge(i), i == 0 || i == K ? -s * c : 2 * (1 - c) * std::sin(i * theta));
        if (K == 2) masks.tangent2 = {{{}, -1}, {edge(1), 1}};
    }
    return masks;
}

namespace detail {

extern constinit const SchemeInfo loop_scheme{
    .name = "loop",
    .title = "Loop 1987",
    .refinement = Refinement::face_split,
    .family = MeshFamily::triangles,
    .interpolating = false,
    .smoothness = "C2",
    .reproduction = 1,
    .generation = "3",
    .lattice = FanLattice::triangles,
    .rings = 2,
    .rule_rings = 1,
    .sees_rings = false,
    .step = loop_step,
    .closed_masks = loop_closed_masks,
    .notes =
        "triangles; boundary, crease, corner, dart, semi-sharp; Warren's weights, C1 edge rule, Hoppe's crease rule",
    .pieces = SurfacePieces::quartic_box,
    .one_ring_limits = true,
    .takes_corner_angles = true,
};

}  // namespace detail
}  // namespace tetrakis
