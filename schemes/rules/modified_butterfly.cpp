#include "modified_butterfly.hpp"

#include "../core/corner_angles.hpp"
#include "../core/scheme_table.hpp"
#include "../parts/face_split.hpp"
#include "../parts/four_point.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace tetrakis {

using std::numbers::pi;

std::vector<double> ModifiedButterfly::extraordinary_ring(int n) {
    // With two edges there are only modes 0 and 1, which have eigenvalues 1/4 and 1/2.
    if (n == 2) return {3.0 / 8, -1.0 / 8};
    if (n == 3) return {5.0 / 12, -1.0 / 12, -1.0 / 12};
    if (n == 4) return {3.0 / 8, 0, -1.0 / 8, 0};
    std::vector<double> s(n);
    for (int i = 0; i < n; ++i) s[i] = (0.25 + std::cos(2 * pi * i / n) + std::cos(4 * pi * i / n) / 2) / n;
    return s;
}

std::vector<double> ModifiedButterfly::crease_ring(int K, int i) {
    const double theta = pi / K;
    std::vector<double> c(K + 2);
    c[0] = 1 - std::sin(theta) * std::sin(i * theta) / (K * (1 - std::cos(theta)));
    for (int j = 1; j < K; ++j)
        c[1 + j] =
            (std::sin(i * theta) * std::sin(j * theta) + std::sin(2 * i * theta) * std::sin(2 * j * theta) / 2) / K;
    const double end = std::cos(i * theta) / 4 - std::sin(2 * theta) * std::sin(2 * i * theta) /
                                                     (4 * K * (std::cos(theta) - std::cos(2 * theta)));
    c[1] = end;
    c[1 + K] = -end;
    return c;
}

namespace {

class ButterflyRules {
  public:
    ButterflyRules(const RuleMesh& mesh, const RuleOptions& options) : mesh_(mesh), options_(options) {
        // The local matrix of a regular vertex has the eigenvalues 1/4 + 6 w and -8 w beside the double 1/2.
        if (!(options.butterfly_w > -1.0 / 16 && options.butterfly_w < 1.0 / 24))
            throw std::invalid_argument(
                "the tension of the ten-point rule must be above -1/16 and below 1/24: with others no vertex has a "
                "tangent plane");
    }

    StencilRow edge(int h) const {
        if (mesh_.sharp(h)) return detail::four_point_edge(mesh_, h);
        const int t = mesh_.twin(h);
        const End u = end(h), v = end(t);
        if (!u.regular && !v.regular) {
            StencilRow row;
            row.add(extraordinary(u), 0.5);
            row.add(extraordinary(v), 0.5);
            return row;
        }
        if (!u.regular) return extraordinary(u);
        if (!v.regular) return extraordinary(v);
        if (options_.reflect_at_boundary || (u.sector.closed && v.sector.closed)) return regular(h);
        if (!u.sector.closed && !v.sector.closed) return between_creases(h);
        return u.sector.closed ? interior_to_crease(h, v) : interior_to_crease(t, u);
    }

    /// The eight- or ten-point rule; a point beyond a sharp edge is the reflection of the triangle on this side.
    StencilRow regular(int h) const {
        const auto w = ModifiedButterfly::regular(options_.butterfly_w);
        StencilRow row{{mesh_.origin(h), w.end}, {mesh_.target(h), w.end}};
        for (const int side : {h, mesh_.twin(h)}) {
            row.add(detail::opposite(mesh_, side), w.opposite);
            add_opposite(row, mesh_.next(side), w.wing);
            add_opposite(row, mesh_.prev(side), w.wing);
            if (w.far != 0) add_beyond(row, side, w.far);
        }
        return row;
    }

  private:
    struct End {
        RuleMesh::Ring sector;
        int vertex, at;  ///< position of the edge in the sector
        bool regular;
    };

    End end(int h) const {
        End e{mesh_.sector(h), mesh_.origin(h), 0, false};
        e.at = e.sector.position(mesh_.target(h));
        e.regular = e.sector.faces() == (e.sector.closed ? 6 : 3);
        return e;
    }

    StencilRow extraordinary(const End& e) const {
        StencilRow row;
        if (!e.sector.closed) {
            const std::vector<double> c = ModifiedButterfly::crease_ring(e.sector.faces(), e.at);
            row.add(e.vertex, c[0]);
            for (int j = 0; j < e.sector.edges(); ++j) row.add(e.sector.neighbour[j], c[1 + j]);
            return row;
        }
        const std::vector<double> s = ModifiedButterfly::extraordinary_ring(e.sector.edges());
        row.add(e.vertex, ModifiedButterfly::extraordinary_vertex);
        for (int j = 0; j < e.sector.edges(); ++j) row.add(e.sector.at(e.at + j), s[j]);
        return row;
    }

    /// Adds the corner opposite the edge of `h` in the face beyond it; beyond a sharp edge, a reflection.
    void add_opposite(StencilRow& row, int h, double weight) const {
        if (!mesh_.sharp(h)) {
            row.add(detail::opposite(mesh_, mesh_.twin(h)), weight);
            return;
        }
        row.add(mesh_.origin(h), weight);
        row.add(mesh_.target(h), weight);
        row.add(detail::opposite(mesh_, h), -weight);
    }
    /// Adds the far point beyond the origin of `h`: the opposite ring vertex, or 2 p_0 - p_1 if there is none.
    void add_beyond(StencilRow& row, int h, double weight) const {
        const End e = end(h);
        const int n = e.sector.edges();
        if (e.sector.closed && n % 2 == 0) {
            row.add(e.sector.at(e.at + n / 2), weight);
        } else {
            row.add(e.vertex, 2 * weight);
            row.add(mesh_.target(h), -weight);
        }
    }

    StencilRow between_creases(int h) const {
        for (const int side : {h, mesh_.twin(h)}) {
            if (!mesh_.sharp(mesh_.next(side)) || !mesh_.sharp(mesh_.prev(side))) continue;
            // The triangle on this side is a corner between the two creases: use the other side.
            const int other = mesh_.twin(side);
            StencilRow row{{mesh_.origin(h), 0.5}, {mesh_.target(h), 0.5}, {detail::opposite(mesh_, other), 0.25}};
            add_opposite(row, mesh_.next(other), -0.125);
            add_opposite(row, mesh_.prev(other), -0.125);
            return row;
        }
        return detail::edge_midpoint(mesh_, h);
    }

    /// From the interior vertex of h to its other end, `crease`, which has three faces on this side.
    StencilRow interior_to_crease(int h, const End& crease) const {
        const bool first = crease.at == 1;
        const int near = crease.sector.neighbour[first ? 0 : 3], far = crease.sector.neighbour[first ? 3 : 0],
                  other = crease.sector.neighbour[first ? 2 : 1];
        StencilRow row{{crease.vertex, 3.0 / 8},
                       {mesh_.origin(h), 5.0 / 8},
                       {near, 1.0 / 16},
                       {other, 3.0 / 16},
                       {far, -1.0 / 16}};
        for (const int side : {h, mesh_.twin(h)}) {
            // The point is beyond the edge that this side's triangle has at the interior vertex.
            const bool is_near = detail::opposite(mesh_, side) == near;
            add_opposite(row, side == h ? mesh_.prev(side) : mesh_.next(side), is_near ? -1.0 / 16 : -1.0 / 8);
        }
        return row;
    }

    const RuleMesh& mesh_;
    const RuleOptions& options_;
};

}  // namespace

RuleStep modified_butterfly_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::need_triangles(mesh, "modified-butterfly");
    const ButterflyRules rules(mesh, options);
    return detail::split_triangles(mesh, detail::HalfSharpness(mesh), options.runner, detail::vertex_itself,
                                   [&](int h) { return rules.edge(h); });
}

RuleStep butterfly_step(const RuleMesh& mesh, const RuleOptions& options) {
    detail::need_triangles(mesh, "butterfly");
    const ButterflyRules rules(mesh, options);
    return detail::split_triangles(
        mesh, detail::HalfSharpness(mesh), options.runner, detail::vertex_itself,
        [&](int h) { return mesh.sharp(h) ? detail::four_point_edge(mesh, h) : rules.regular(h); });
}

ClosedMasks butterfly_closed_masks(const FanShape& shape, const RuleOptions& options) {
    ClosedMasks masks;
    masks.limit = {{{}, 1}};
    const int n = shape.faces;
    if (shape.corner) return masks;
    if (shape.boundary) masks.tangent1 = detail::four_point_tangent(0, n);
    if (shape.boundary || n != 6 || shape.dart || options.butterfly_w != 0) return masks;
    const struct {
        int a, b;
        double weight, turn;  ///< the turn in sectors
    } places[] = {{1, 0, 16, 0}, {1, 1, -8 / std::numbers::sqrt3, 0.5}, {2, 0, 1, 0}};
    for (int i = 0; i < 6; ++i)
        for (const auto& [a, b, weight, turn] : places) {
            const double angle = (i + turn) * pi / 3;
            masks.tangent1.emplace_back(FanLabel{i, a, b}, weight * std::cos(angle));
            masks.tangent2.emplace_back(FanLabel{i, a, b}, weight * std::sin(angle));
        }
    return masks;
}

ClosedMasks modified_butterfly_closed_masks(const FanShape& shape, const RuleOptions& options) {
    ClosedMasks masks = butterfly_closed_masks(shape, options);
    if (shape.boundary || shape.corner || shape.dart || shape.faces == 6 || shape.faces < 3) return masks;
    ClosedMasks ring = ring_closed_masks(shape.faces, {.vertex = 1});
    ring.limit = std::move(masks.limit);
    return ring;
}

namespace detail {

extern constinit const SchemeInfo butterfly_scheme{
    .name = "butterfly",
    .title = "Butterfly, Dyn, Levin, Gregory 1990",
    .refinement = Refinement::face_split,
    .family = MeshFamily::triangles,
    .interpolating = true,
    .smoothness = "C1",
    .reproduction = 3,
    .generation = "3",
    .lattice = FanLattice::triangles,
    .rings = 4,
    .rule_rings = 2,
    .step = butterfly_step,
    .closed_masks = butterfly_closed_masks,
    .notes = "triangles; boundary by four-point and reflection; not smooth at valence 3",
};

extern constinit const SchemeInfo modified_butterfly_scheme{
    .name = "modified-butterfly",
    .title = "Modified Butterfly, Zorin, Schroeder, Sweldens 1996",
    .refinement = Refinement::face_split,
    .family = MeshFamily::triangles,
    .interpolating = true,
    .smoothness = "C1",
    .reproduction = 3,
    .generation = "3",
    .lattice = FanLattice::triangles,
    .rings = 4,
    .rule_rings = 2,
    .sees_rings = true,
    .step = modified_butterfly_step,
    .closed_masks = modified_butterfly_closed_masks,
    .notes = "triangles; boundary, crease, corner; reflection at boundaries as an option",
};

}  // namespace detail
}  // namespace tetrakis
