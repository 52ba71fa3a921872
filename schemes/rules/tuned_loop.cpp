#include "tuned_loop.hpp"

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

namespace {

/// Eigenvalue of Fourier mode j, 0 <= j < n.
double mode(int n, int j, double tuning) {
    if (j == 0) return 5.0 / 8;
    const int frequency = std::min(j, n - j);
    const double prescribed = frequency == 1 ? 0.5 : frequency == 2 ? 0.25 : 0.125;
    return (1 - tuning) * Loop::mode_eigenvalue(2 * pi * j / n) + tuning * prescribed;
}

/// The ring of the half-edge's origin if the vertex has tuned rules.
bool tuned(const RuleMesh& mesh, int h, RuleMesh::Ring& ring) {
    const int v = mesh.origin(h);
    ring = mesh.ring(v);
    return ring.closed && ring.edges() != 6 && ring.edges() > 2 && mesh.rule(v) == VertexRule::smooth;
}

}  // namespace

std::vector<double> TunedLoop::edge_ring(int n, double tuning) {
    std::vector<double> b(n, 0.0);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) b[i] += mode(n, j, tuning) * std::cos(2 * pi * i * j / n) / n;
    return b;
}

double TunedLoop::beta(int n, double tuning) {
    if (n < 3) return Loop::beta(n);
    return (1 - tuning) * Loop::beta(n) + tuning * 3.0 / (8 * n);
}

RuleStep tuned_loop_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::need_triangles(mesh, "tuned-loop");
    detail::check_corner_angle(options);
    if (!(std::abs(options.tuning) <= 1e6)) throw std::invalid_argument("the tuning must be a number from -1e6 to 1e6");
    std::map<int, std::vector<double>> rings;  // by valence
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        RuleMesh::Ring ring;
        if (mesh.first(v) == RuleMesh::none || !tuned(mesh, mesh.first(v), ring)) continue;
        std::vector<double>& b = rings[ring.edges()];
        if (b.empty()) b = TunedLoop::edge_ring(ring.edges(), options.tuning);
    }
    return detail::split_triangles(
        mesh, options.runner,
        [&](int v) -> StencilRow {
            const RuleMesh::Ring ring = mesh.ring(v);
            if (ring.faces() == 0) return {{v, 1}};
            return detail::blended_vertex_row(mesh, v, ring, [&] {
                const int n = ring.edges();
                const double beta = TunedLoop::beta(n, options.tuning);
                StencilRow row{{v, 1 - n * beta}};
                for (const int e : ring.neighbour) row.add(e, beta);
                return row;
            });
        },
        [&](int h) {
            const float s = mesh.sharpness(h), child = child_sharpness(s);
            const double crease = edge_crease_weight(s, child, child);
            StencilRow row;
            if (crease != 0) row.add(detail::loop_crease_edge_row(mesh, h, options), crease);
            if (crease == 1) return row;
            StencilRow smooth;
            int ends = 0;
            for (const int from : {h, mesh.twin(h)}) {
                RuleMesh::Ring ring;
                if (!tuned(mesh, from, ring)) continue;
                ++ends;
                const int n = ring.edges(), at = ring.position(mesh.target(from));
                const std::vector<double>& b = rings.at(n);
                smooth.add(mesh.origin(from), TunedLoop::edge_vertex);
                for (int i = 0; i < n; ++i) smooth.add(ring.at(at + i), b[i]);
            }
            if (ends == 0) smooth = detail::loop_smooth_edge_row(mesh, h, options);
            row.add(smooth, (1 - crease) / std::max(ends, 1));
            return row;
        });
}

ClosedMasks tuned_loop_closed_masks(const FanShape& shape, const RuleOptions& options) {
    if (shape.boundary || shape.dart || shape.corner) {
        RuleOptions loop = options;
        loop.loop_weights = LoopWeights::loop;
        return loop_closed_masks(shape, loop);
    }
    const int n = shape.faces;
    // Left eigenvector of mode 0: c n beta = 3/8 of the ring's total.
    const double total = 8 * n * TunedLoop::beta(n, options.tuning) / 3;
    return ring_closed_masks(n, {.vertex = 1 / (1 + total), .edge = total / (1 + total) / n},
                             mode(n, 1, n < 3 ? 0 : options.tuning));
}

namespace detail {

extern constinit const SchemeInfo tuned_loop_scheme{
    .name = "tuned-loop",
    .title = "Loop with prescribed eigenvalues",
    .refinement = Refinement::face_split,
    .family = MeshFamily::triangles,
    .interpolating = false,
    .smoothness = "C2",
    .reproduction = 1,
    .generation = "3",
    .lattice = FanLattice::triangles,
    .rings = 2,
    .rule_rings = 1,
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
