#include "kobbelt.hpp"

#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"
#include "../parts/four_point.hpp"
#include "linear.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

Kobbelt::VirtualPoint Kobbelt::virtual_point(int n) {
    // v_0 = 4/n sum e_j - (e_(-1) + e_0 + e_1) - w/a (f_(-2) + f_(-1) + f_0 + f_1) + 4 w / (a n) sum f_j
    const double q = w / a;
    VirtualPoint v{std::vector<double>(n, 4.0 / n), std::vector<double>(n, 4 * q / n)};
    for (const int i : {-1, 0, 1}) v.edge[(i + n) % n] -= 1;
    for (const int i : {-2, -1, 0, 1}) v.face[(i + 2 * n) % n] -= q;
    return v;
}

std::vector<double> Kobbelt::boundary_point(int K, int i) {
    // 2 c minus the fit c + cos(i theta) A + sin(i theta) B, where A = (p_0 - p_K) / 2 and
    // B = 2/K sum over j of sin(j theta) (p_j - c - cos(j theta) A); the cosines cancel in that sum.
    const double theta = std::numbers::pi / K, ci = std::cos(i * theta), si = std::sin(i * theta);
    std::vector<double> weights(K + 2, 0.0);
    weights[0] = 1;
    weights[1] -= ci / 2;
    weights[1 + K] += ci / 2;
    for (int j = 1; j < K; ++j) {
        const double b = 2.0 / K * si * std::sin(j * theta);
        weights[1 + j] -= b;
        weights[0] += b;
    }
    return weights;
}

namespace {

class Rules {
  public:
    Rules(const RuleMesh& mesh, const BlockRunner* runner) : mesh_(mesh), extraordinary_(mesh.vertex_count(), 0) {
        for (int v = 0; v < mesh.vertex_count(); ++v)
            if (mesh.first(v) != RuleMesh::none && !mesh.on_boundary(v))
                extraordinary_[v] = mesh.ring(v).edges() != 4 && mesh.sharp_neighbours(v).size() < 2;
        edges_.push_rows(runner, mesh.edge_count(), [&](int e) { return make_edge(mesh.edge_halfedge(e)); });
    }

    StencilRow edge(int h) const { return edges_.row(mesh_.edge(h)); }

    StencilRow face(int f) const {
        const int h = mesh_.face_begin(f);
        int met[2];
        StencilRow rows[2];
        for (int i = 0; i < 2; ++i) rows[i] = across(h + i, h + i + 2, met[i]);
        if (met[0] != met[1]) return rows[met[0] < met[1] ? 0 : 1];
        StencilRow mean;
        mean.add(rows[0], 0.5);
        mean.add(rows[1], 0.5);
        return mean;
    }

  private:
    void add_edge(StencilRow& row, int h, double weight) const { edges_.add_row(mesh_.edge(h), weight, row); }
    StencilRow make_edge(int h) const {
        if (mesh_.sharp(h)) return detail::four_point_edge(mesh_, h);
        StencilRow row{{mesh_.origin(h), Kobbelt::a}, {mesh_.target(h), Kobbelt::a}};
        add_beyond(row, h);
        add_beyond(row, mesh_.twin(h));
        return row;
    }

    /// Adds w times the point beyond the origin of smooth half-edge `h`, on its row.
    void add_beyond(StencilRow& row, int h) const {
        const int v = mesh_.origin(h);
        const RuleMesh::Ring ring = mesh_.sector(h);
        const int n = ring.edges(), at = ring.position(mesh_.target(h));
        if (!ring.closed) {
            if (mesh_.rule(v) == VertexRule::crease) {
                const std::vector<double> point = Kobbelt::boundary_point(ring.faces(), at);
                row.add(v, Kobbelt::w * point[0]);
                for (int i = 0; i < n; ++i) row.add(ring.neighbour[i], Kobbelt::w * point[1 + i]);
            } else {
                row.add(v, 2 * Kobbelt::w);
                row.add(mesh_.target(h), -Kobbelt::w);
            }
            return;
        }
        if (n == 4) {
            row.add(ring.at(at + 2), Kobbelt::w);
            return;
        }
        const Kobbelt::VirtualPoint point = Kobbelt::virtual_point(n);
        for (int i = 0; i < n; ++i) {
            row.add(ring.at(at + i), Kobbelt::w * point.edge[i]);
            const int face = ring.halfedge[ring.wrap(at + i)];
            row.add(mesh_.origin(mesh_.prev(mesh_.prev(face))), Kobbelt::w * point.face[i]);
        }
    }

    /// The face point by the row of edge points that crosses the face's opposite edges g and k. The row is continued
    /// into the next faces, or beyond a sharp edge by 2 p_0 - p_1. `met` counts extraordinary ends of the row's edges.
    StencilRow across(int g, int k, int& met) const {
        StencilRow row;
        met = 0;
        for (const auto& [near, opposite] : {std::pair(g, k), std::pair(k, g)}) {
            met += extraordinary_[mesh_.origin(near)] + extraordinary_[mesh_.target(near)];
            add_edge(row, near, Kobbelt::a);
            if (mesh_.sharp(near)) {
                add_edge(row, near, 2 * Kobbelt::w);
                add_edge(row, opposite, -Kobbelt::w);
                continue;
            }
            const int far = mesh_.next(mesh_.next(mesh_.twin(near)));
            met += extraordinary_[mesh_.origin(far)] + extraordinary_[mesh_.target(far)];
            add_edge(row, far, Kobbelt::w);
        }
        return row;
    }

    const RuleMesh& mesh_;
    std::vector<char> extraordinary_;
    StencilTable edges_;
};

}  // namespace

RuleStep kobbelt_step(const RuleMesh& mesh, const RuleOptions& options) {
    if (!mesh.all_faces_have(4)) return bilinear_step(mesh, options);
    const Rules rules(mesh, options.runner);
    return detail::split_polygons(
        mesh, detail::HalfSharpness(mesh), options.runner, detail::vertex_itself, [&](int h) { return rules.edge(h); },
        [&](int f) { return rules.face(f); });
}

namespace detail {

extern constinit const SchemeInfo kobbelt_scheme{
    .name = "kobbelt",
    .title = "Kobbelt 1996",
    .refinement = Refinement::face_split,
    .family = MeshFamily::quads,
    .interpolating = true,
    .smoothness = "C1",
    .reproduction = 3,
    .generation = "3",
    .lattice = FanLattice::quads,
    .rings = 4,
    .rule_rings = 2,
    .sees_rings = true,
    .step = kobbelt_step,
    .closed_masks = linear_closed_masks,
    .notes = "quads (others after one bilinear step); boundary and crease by four-point",
    .choice_rings = 2,
    .first_step = bilinear_step,
};

}  // namespace detail
}  // namespace tetrakis
