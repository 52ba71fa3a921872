#include "honeycomb_limit.hpp"

#include "../core/rule_step.hpp"
#include "../core/scheme_table.hpp"

#include <algorithm>
#include <cmath>

namespace tetrakis::detail {

namespace {

constexpr int k_hexagon = 6, k_per_edge = 7;

bool plain(const RuleMesh& mesh, int v, const RuleMesh::Ring& ring) {
    return ring.closed && mesh.vertex_sharpness(v) == 0 &&
           std::all_of(ring.sharpness.begin(), ring.sharpness.end(), [](float s) { return s == 0; });
}

/// A vertex and its hexagons, and those beyond its neighbours: numbered as honeycomb_fan() lists them.
RuleMesh fan_mesh(int n) {
    RuleMesh::Builder faces;
    const auto at = [&](int edge, int k) { return 1 + (edge + n) % n * k_per_edge + k; };
    for (int i = 0; i < n; ++i) {
        faces.face({0, at(i, 0), at(i, 1), at(i, 2), at(i, 3), at(i + 1, 0)});
        faces.face({at(i, 0), at(i - 1, 3), at(i, 4), at(i, 5), at(i, 6), at(i, 1)});
    }
    return RuleMesh(1 + n * k_per_edge, std::move(faces));
}

}  // namespace

std::optional<std::vector<int>> honeycomb_fan(const RuleMesh& mesh, int v) {
    const RuleMesh::Ring ring = mesh.ring(v);
    if (ring.edges() < 2 || !plain(mesh, v, ring)) return std::nullopt;
    std::vector<int> fan{v};
    for (const int h : ring.halfedge) {
        const int e = mesh.target(h);
        const RuleMesh::Ring around = mesh.ring(e);
        if (mesh.face_size(mesh.face(h)) != k_hexagon || around.edges() != 3 || !plain(mesh, e, around))
            return std::nullopt;
        fan.push_back(e);
        int at = mesh.next(h);
        const int beyond = mesh.twin(at);
        for (int k = 0; k < 3; ++k, at = mesh.next(at)) fan.push_back(mesh.target(at));
        if (mesh.face_size(mesh.face(beyond)) != k_hexagon) return std::nullopt;
        at = mesh.next(mesh.next(beyond));
        for (int k = 0; k < 3; ++k, at = mesh.next(at)) fan.push_back(mesh.target(at));
    }
    return fan;
}

std::vector<double> honeycomb_limit_weights(int valence) {
    const RuleMesh mesh = fan_mesh(valence);
    const RuleStep step = find_scheme("honeycomb")->step(mesh, {});
    const std::vector<int> coarse = *honeycomb_fan(mesh, 0), fine = *honeycomb_fan(step.mesh, 0);
    std::vector<int> number(mesh.vertex_count());
    for (std::size_t i = 0; i < coarse.size(); ++i) number[coarse[i]] = static_cast<int>(i);
    // The row of the middle after so many steps; what is left of the other modes shrinks by more than 2 each.
    std::vector<double> row(coarse.size(), 0.0);
    row[0] = 1;
    constexpr int k_most_steps = 200;
    for (int i = 0; i < k_most_steps; ++i) {
        std::vector<double> next(row.size(), 0.0);
        double change = 0;
        for (std::size_t r = 0; r < fine.size(); ++r) {
            const auto points = step.stencils.points(fine[r]);
            const auto weights = step.stencils.weights(fine[r]);
            for (std::size_t t = 0; t < points.size(); ++t) next[number[points[t]]] += row[r] * weights[t];
        }
        for (std::size_t r = 0; r < row.size(); ++r) change = std::max(change, std::abs(next[r] - row[r]));
        row = std::move(next);
        if (change < 1e-17) break;
    }
    return row;
}

}  // namespace tetrakis::detail
