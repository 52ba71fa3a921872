#include "../core/scheme_table.hpp"
#include "../parts/averaging_level.hpp"
#include "../parts/corner_weights.hpp"
#include "../parts/face_split.hpp"
#include "catmull_clark.hpp"
#include "dual_schemes.hpp"
#include "linear.hpp"

namespace tetrakis {

namespace {

/// Row of the bilinear split's point at AveragingLevel::place() `place`.
StencilRow bilinear_row(const RuleMesh& mesh, int place) {
    const int edge = place - mesh.vertex_count(), face = edge - mesh.edge_count();
    if (face >= 0) return detail::face_mean(mesh, face);
    if (edge < 0) return detail::vertex_itself(place);
    return detail::edge_midpoint(mesh, mesh.edge_halfedge(edge));
}

/// Row of a new point at AveragingLevel::place() `place`: Catmull-Clark's sharp rules blended with the `average`.
StencilRow blended_row(const RuleMesh& mesh, int place, const StencilRow& average) {
    const int edge = place - mesh.vertex_count(), face = edge - mesh.edge_count();
    if (face >= 0) return detail::face_mean(mesh, face);
    const detail::HalfSharpness halves(mesh);
    const auto smooth = [&](const auto&...) { return average; };
    if (edge < 0) return detail::blended_vertex_row(mesh, place, halves, smooth);
    return detail::blended_edge_row(halves.crease_weight(mesh.edge_halfedge(edge)), bilinear_row(mesh, place), smooth);
}

/// Repeated averaging (Zorin, Schroeder 2001; Warren, Weimer; Stam 2001): every k-gon is split in k quads, then m times
/// each quad's centroid becomes a vertex. m = 0 bilinear, 1 Doo-Sabin with Catmull and Clark's weights, 2 nearly
/// Catmull-Clark, 3 biquartic; on quads the tensor product B-spline of degree m + 1. Even m: primal, odd m: dual.
///
/// AveragingBoundary::replicate: m = 2 has Catmull-Clark's rules at boundaries and creases. For other m > 0, layers of
/// copies of the boundary vertices surround the mesh, (m + 3) / 4 of them; a tagged boundary vertex has a quad of its
/// own copies as well. AveragingBoundary::recede: only points that need no missing point are made. So each step takes
/// m / 4 rings off the boundary, and the surface ends inside. If m > 0 has no crease rules, tags inside are ignored.
/// @throws std::invalid_argument  the number of steps is not from 0 to 64, or nothing of the mesh is left
RuleStep averaging_step(const RuleMesh& mesh, const RuleOptions& options) {
    const detail::AveragingLevel level(mesh, options);
    std::vector<char> made = level.made();
    StencilTable points;
    const auto make_points = [&](const auto& row) {
        StencilTable next;
        next.push_rows(options.runner, static_cast<int>(made.size()),
                       [&](int point) { return made[point] ? row(point) : StencilRow(); });
        points = std::move(next);
    };
    make_points([&](int v) { return bilinear_row(level.mesh(), level.place(v)); });
    for (int i = 0; i < level.averagings(); ++i) {
        made = level.made(i, made);
        make_points([&](int point) {
            StencilRow row;
            const auto around = level.around(i, point);
            for (const int p : around) points.add_row(p, 1.0 / static_cast<double>(around.size()), row);
            return row;
        });
    }
    return level
        .end(made, options.runner,
             [&](int point) {
                 const StencilRow row = points.row(point);
                 return level.has_sharp_rules() ? blended_row(level.mesh(), level.place(point), row) : row;
             })
        .step;
}

ClosedMasks averaging_closed_masks(const FanShape& shape, const RuleOptions& options) {
    const int m = options.averaging_steps, n = shape.faces;
    ClosedMasks masks;
    if (m == 0) return linear_closed_masks(shape, options);
    if (m == 1) return detail::corner_weights_closed_masks(shape, options);
    const auto add = [&](FanLabel label, double weight) { masks.limit.emplace_back(label, weight); };
    if (m == 2) {
        if (shape.dart || (shape.corner && !shape.boundary)) return masks;
        if (shape.corner) return linear_closed_masks(shape, options);
        if (shape.boundary) return crease_closed_masks(n);
        return CatmullClark::ring_closed_masks(n, {.vertex = 4.0 / 9, .edge = 4.0 / (9 * n), .face = 1.0 / (9 * n)});
    }
    if (m != 3) return masks;
    // At an end, in one direction: p_0, p_1 have the children (15, 1) / 16 and (11, 5) / 16, so the limit (11, 1) / 12.
    if (shape.corner) {
        for (const FanLabel edge : {FanLabel{0, 1, 0}, FanLabel{1, 1, 0}}) add(edge, 11.0 / 144);
        add({}, 121.0 / 144);
        add({0, 1, 1}, 1.0 / 144);
        return masks;
    }
    if (shape.boundary) return masks;
    for (int i = 0; i < n; ++i) {
        add({i, 0, 0}, 484.0 / (576 * n));
        add({i, 1, 0}, 88.0 / (2 * 576 * n));
        add({i, 0, 1}, 88.0 / (2 * 576 * n));
        add({i, 1, 1}, 4.0 / (576 * n));
    }
    return masks;
}

RuleOptions three_steps(RuleOptions options) {
    options.averaging_steps = 3;
    return options;
}

}  // namespace

namespace detail {

extern constinit const SchemeInfo biquartic_scheme{
    .name = "biquartic",
    .title = "Biquartic, Zorin, Schroeder 2001",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .smoothness = "C3",
    .generation = "bi-4",
    .lattice = FanLattice::dual,
    .rings = 2,
    .rule_rings = 2,
    .sees_rings = true,
    .step = [](const RuleMesh& mesh, const RuleOptions& options) { return averaging_step(mesh, three_steps(options)); },
    .closed_masks = [](const FanShape& shape,
                       const RuleOptions& options) { return averaging_closed_masks(shape, three_steps(options)); },
    .notes = "any polygons; boundary by copies of its vertices, or the outer ring is used up; no creases",
    .averaging_steps = 3,
};

extern constinit const SchemeInfo averaging_scheme{
    .name = "averaging",
    .title = "Repeated averaging, m steps",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .smoothness = "Cm",
    .generation = "bi-(m + 1)",
    .lattice = FanLattice::dual,
    .rings = 2,
    .sees_rings = true,
    .step = averaging_step,
    .closed_masks = averaging_closed_masks,
    .notes =
        "any polygons; m = 0 bilinear, 1 doo-sabin-cc, 2 nearly catmull-clark (with its creases), 3 biquartic; "
        "even m: face split",
    .averaging_steps = SchemeInfo::k_chosen_steps,
};

}  // namespace detail
}  // namespace tetrakis
