#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"
#include "loop.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace tetrakis {

using std::numbers::pi;

// Loop's scheme with prescribed eigenvalues at extraordinary vertices (the modified Loop scheme that the SIGGRAPH 2000
// course notes describe, section 4.8, without coefficients; these are derived here).
//
// The point on an edge at an extraordinary vertex c has weights 3/8 of c and b_i of the whole ring. So the ring's block
// of Fourier mode j is the single number sum b_i cos(2 pi i j / n). The prescribed values are those at a regular
// vertex: 5/8 for mode 0 (with 3/8 of c the row sums to one), 1/2 for modes +-1, 1/4 for +-2, 1/8 for the others. b is
// their inverse transform. The ring has weight 3/8 in the rule of c, as at a regular vertex, so the other eigenvalue of
// mode 0 is 1/4. With `tuning` t every eigenvalue is (1 - t) Loop's + t the prescribed one; t = 0 is Loop. t = 1 gives
// evenly sized triangles and no crease at high valence, but larger ripples inside the first ring. On a parabolic ridge
// at valence 12 and 24 they are seven and ten times Loop's, 0.0006 and 0.0003 of an edge's length (tools/figures, sheet
// tuned_loop).

namespace {

/// Eigenvalue of Fourier mode j, 0 <= j < n.
double mode(int n, int j, double tuning) {
    if (j == 0) return 5.0 / 8;
    const int frequency = std::min(j, n - j);
    const double prescribed = frequency == 1 ? 0.5 : frequency == 2 ? 0.25 : 0.125;
    return (1 - tuning) * Loop::mode_eigenvalue(2 * pi * j / n) + tuning * prescribed;
}

/// Whether the origin of half-edge `h` has tuned rules. @param ring  receives its ring
bool tuned(const RuleMesh& mesh, int h, RuleMesh::Ring& ring) {
    const int v = mesh.origin(h);
    ring = mesh.ring(v);
    return ring.closed && ring.edges() != 6 && ring.edges() > 2 && mesh.rule(v) == VertexRule::smooth;
}

/// The weights b_i, i = 0 .. n - 1, for the edge to ring vertex 0.
std::vector<double> edge_ring(int n, double tuning) {
    std::vector<double> b(n, 0.0);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) b[i] += mode(n, j, tuning) * std::cos(2 * pi * i * j / n) / n;
    return b;
}
constexpr double k_edge_vertex = 3.0 / 8;

/// Weight of each neighbour in the vertex rule; with two edges all rules are Loop's.
double vertex_beta(int n, double tuning) {
    if (n < 3) return Loop::beta(n);
    return (1 - tuning) * Loop::beta(n) + tuning * 3.0 / (8 * n);
}

/// One step. Boundary, creases, corners, darts as for Loop; an edge between two extraordinary vertices takes the mean
/// of their rules. @throws std::invalid_argument  as loop_step(), or the tuning is not from -1e6 to 1e6
RuleStep tuned_loop_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::need_triangles(mesh, "tuned-loop");
    if (!(std::abs(options.tuning) <= 1e6)) throw std::invalid_argument("the tuning must be a number from -1e6 to 1e6");
    std::map<int, std::vector<double>> rings;  // by valence
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        RuleMesh::Ring ring;
        if (mesh.first(v) == RuleMesh::none || !tuned(mesh, mesh.first(v), ring)) continue;
        std::vector<double>& b = rings[ring.edges()];
        if (b.empty()) b = edge_ring(ring.edges(), options.tuning);
    }
    const auto smooth_edge_row = [&](int h) {
        StencilRow sum, row;
        int ends = 0;
        for (const int from : {h, mesh.twin(h)}) {
            RuleMesh::Ring ring;
            if (!tuned(mesh, from, ring)) continue;
            ++ends;
            const int n = ring.edges(), at = ring.position(mesh.target(from));
            const std::vector<double>& b = rings.at(n);
            sum.add(mesh.origin(from), k_edge_vertex);
            for (int i = 0; i < n; ++i) sum.add(ring.at(at + i), b[i]);
        }
        if (ends == 0) return detail::loop_smooth_edge_row(mesh, h, options);
        row.add(sum, 1.0 / ends);
        return row;
    };
    return detail::loop_like_step(
        mesh, options, "tuned-loop", false, [&](int n) { return vertex_beta(n, options.tuning); }, smooth_edge_row);
}

ClosedMasks tuned_loop_closed_masks(const FanShape& shape, const RuleOptions& options) {
    if (shape.boundary || shape.dart || shape.corner) {
        RuleOptions loop = options;
        loop.loop_weights = LoopWeights::loop;
        return loop_closed_masks(shape, loop);
    }
    const int n = shape.faces;
    // Left eigenvector of mode 0: c n beta = 3/8 of the ring's total.
    const double total = 8 * n * vertex_beta(n, options.tuning) / 3;
    return ring_closed_masks(n, {.vertex = 1 / (1 + total), .edge = total / (1 + total) / n});
}

}  // namespace

namespace detail {

extern constinit const SchemeInfo tuned_loop_scheme{
    .name = "tuned-loop",
    .title = "Loop with prescribed eigenvalues",
    .refinement = Refinement::face_split,
    .family = MeshFamily::triangles,
    .smoothness = "C2",
    .generation = "3",
    .lattice = FanLattice::triangles,
    .rings = 2,
    .sees_rings = true,
    .step = tuned_loop_step,
    .closed_masks = tuned_loop_closed_masks,
    .notes =
        "triangles; boundary and creases as loop; tuning 0 (loop) to 1 (even triangles, no crease at high valence, "
        "larger ripples beside the vertex)",
    .takes_corner_angles = true,
};

}  // namespace detail
}  // namespace tetrakis
