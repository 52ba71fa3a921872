#include "loop.hpp"

#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"

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

// Most triangles beside a crease with which the plain rule still has a tangent plane. For so many or fewer, the brief
// form of the C1 rule is the plain rule.
constexpr int k_plain_triangles = 5;

bool is_regular_crease(const RuleMesh& mesh, int v) {
    const RuleMesh::Ring ring = mesh.ring(v);
    if (vertex_rule(ring.sharpness, mesh.vertex_sharpness(v)) != VertexRule::crease) return false;
    if (!ring.closed) return ring.faces() == 3;
    std::vector<int> sharp;
    for (int i = 0; i < ring.edges(); ++i)
        if (is_sharp(ring.sharpness[i])) sharp.push_back(i);
    return ring.faces() == 6 && sharp[1] - sharp[0] == 3;
}

StencilRow crease_edge_row(const RuleMesh& mesh, int h, const RuleOptions& options) {
    const int u = mesh.origin(h), v = mesh.target(h);
    if (options.hoppe_crease && mesh.rule(u) == VertexRule::crease && mesh.rule(v) == VertexRule::crease) {
        const bool ru = is_regular_crease(mesh, u), rv = is_regular_crease(mesh, v);
        if (ru != rv) return {{u, ru ? 5.0 / 8 : 3.0 / 8}, {v, rv ? 5.0 / 8 : 3.0 / 8}};
    }
    return detail::edge_midpoint(mesh, h);
}

}  // namespace

StencilRow detail::loop_smooth_edge_row(const RuleMesh& mesh, int h, const RuleOptions& options) {
    const int t = mesh.twin(h);
    StencilRow row{{detail::opposite(mesh, h), Loop::edge_opposite}, {detail::opposite(mesh, t), Loop::edge_opposite}};
    if (const auto bend = bend_at(mesh, h, options, k_plain_triangles)) {
        const double gamma = 0.5 - std::cos(bend->theta) / 4;
        row.add(mesh.origin(bend->out), 0.75 - gamma);
        row.add(mesh.target(bend->out), gamma);
        return flattened_edge(row, mesh, *bend,
                              [](int K, double theta) { return 0.5 + (std::cos(pi / K) - std::cos(theta)) / 4; });
    }
    row.add(mesh.origin(h), Loop::edge_end);
    row.add(mesh.target(h), Loop::edge_end);
    return row;
}

RuleStep detail::loop_like_step(const RuleMesh& mesh, const RuleOptions& options, const char* name, bool chaikin,
                                const std::function<double(int)>& beta,
                                const std::function<StencilRow(int)>& smooth_edge) {
    need_triangles(mesh, name);
    check_corner_angle(options);
    const HalfSharpness halves(mesh, chaikin);
    return split_triangles(
        mesh, halves, options.runner,
        [&](int v) {
            return blended_vertex_row(mesh, v, halves, [&](const RuleMesh::Ring& ring) {
                const int n = ring.edges();
                return ring_row(v, ring, Loop::vertex_mask(n, beta(n)));
            });
        },
        [&](int h) {
            return blended_edge_row(halves.crease_weight(h), crease_edge_row(mesh, h, options),
                                    [&] { return smooth_edge(h); });
        });
}

RuleStep loop_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::loop_like_step(mesh, options, "loop", options.chaikin_creases,
                                  options.loop_weights == LoopWeights::warren ? Loop::beta_warren : Loop::beta,
                                  [&](int h) { return detail::loop_smooth_edge_row(mesh, h, options); });
}

ClosedMasks loop_closed_masks(const FanShape& shape, const RuleOptions& options) {
    if (shape.dart || (shape.corner && !shape.boundary)) return {};
    const int n = shape.faces;
    if (!shape.boundary) {
        const double beta = options.loop_weights == LoopWeights::warren ? Loop::beta_warren(n) : Loop::beta(n);
        return ring_closed_masks(n, Loop::limit_mask(n, beta));
    }
    // Two triangles at a corner: the edge between them turns into the plane of the sharp ones, with eigenvalue 3/8.
    if (shape.corner) return corner_closed_masks(n, n <= 2 || shape.angle > 0 || options.corner_angle > 0);
    const bool plain = options.edge_beside_crease == EdgeBesideCrease::plain;
    const double theta = pi / n, c = std::cos(theta), s = std::sin(theta);
    ClosedMasks masks = crease_closed_masks(n);
    if (options.hoppe_crease && n != 3) {
        masks.limit = {{{}, 3.0 / 5}, {{0, 1, 0}, 1.0 / 5}, {{n, 1, 0}, 1.0 / 5}};
        masks.tangent1.clear();
        if (n < 4 || !plain) return masks;
        masks.tangent2 = AcrossMask{.vertex = 0, .end = s, .inner = 2 * c - 2}.mask(n);
        return masks;
    }
    if (n > 1 && options.edge_beside_crease == EdgeBesideCrease::brief) return masks;
    AcrossMask across;
    if (n > 1 && plain)
        across = AcrossMask::solve(Loop::mode_eigenvalue(theta), Loop::edge_opposite * s,
                                   Loop::edge_end / std::tan(theta / 2), 1);
    else if (n > 1)
        across = n == 2 ? AcrossMask{.vertex = -1, .end = 0, .inner = 1}
                        : AcrossMask{.vertex = -2 * (1 - c) * s, .end = -s * c, .inner = 2 * (1 - c)};
    masks.tangent2 = across.mask(n);
    return masks;
}

namespace detail {

extern constinit const SchemeInfo loop_scheme{
    .name = "loop",
    .title = "Loop 1987",
    .refinement = Refinement::face_split,
    .family = MeshFamily::triangles,
    .smoothness = "C2",
    .generation = "3",
    .lattice = FanLattice::triangles,
    .rings = 2,
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
