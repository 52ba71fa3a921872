#include "averaging.hpp"

#include "../core/scheme_table.hpp"
#include "../parts/averaging_level.hpp"
#include "../parts/corner_weights.hpp"
#include "../parts/face_split.hpp"
#include "catmull_clark.hpp"
#include "dual_schemes.hpp"
#include "linear.hpp"

#include <cmath>
#include <numbers>
#include <utility>

namespace tetrakis {

namespace {

StencilRow gathered(StencilRow row) {
    row.gather();
    return row;
}

/// Of the bilinear split, at a place of the level.
StencilRow bilinear_row(const RuleMesh& mesh, int place) {
    const int edge = place - mesh.vertex_count(), face = edge - mesh.edge_count();
    if (face >= 0) return gathered(detail::face_mean(mesh, face));
    if (edge < 0) return {{place, 1}};
    const int h = mesh.edge_halfedge(edge);
    return gathered({{mesh.origin(h), 0.5}, {mesh.target(h), 0.5}});
}

/// Catmull-Clark's blend at a place of the level, of its sharp rules and of the averages.
StencilRow blended_row(const RuleMesh& mesh, int place, const StencilRow& average) {
    const int edge = place - mesh.vertex_count(), face = edge - mesh.edge_count();
    if (face >= 0) return detail::face_mean(mesh, face);
    if (edge < 0) return detail::blended_vertex_row(mesh, place, mesh.ring(place), [&] { return average; });
    const double crease = detail::uniform_crease_weight(mesh.sharpness(mesh.edge_halfedge(edge)));
    StencilRow row;
    if (crease != 0) row.add(bilinear_row(mesh, place), crease);
    if (crease != 1) row.add(average, 1 - crease);
    return row;
}

}  // namespace

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

RuleStep biquartic_step(const RuleMesh& mesh, const RuleOptions& options) {
    RuleOptions three = options;
    three.averaging_steps = 3;
    return averaging_step(mesh, three);
}

ClosedMasks averaging_closed_masks(const FanShape& shape, const RuleOptions& options) {
    const int m = options.averaging_steps, n = shape.faces;
    ClosedMasks masks;
    if (m == 0) return linear_closed_masks(shape, options);
    if (m == 1) return detail::corner_weights_closed_masks(shape, DooSabin::eigenvalue_catmull_clark(n));
    const auto add = [&](FanLabel label, double weight) { masks.limit.emplace_back(label, weight); };
    if (m == 2) {
        if (shape.dart || (shape.corner && !shape.boundary)) return masks;
        if (shape.corner) return linear_closed_masks(shape, options);
        if (shape.boundary) return crease_closed_masks(n);
        const double angle = 2 * std::numbers::pi / n, A = CatmullClark::tangent_edge_factor(angle);
        masks.lambda1 = masks.lambda2 = CatmullClark::mode_eigenvalue(angle);
        add({}, 4.0 / 9);
        for (int i = 0; i < n; ++i) {
            const FanLabel edge{i, 1, 0}, face{i, 1, 1};
            add(edge, 4.0 / (9 * n));
            add(face, 1.0 / (9 * n));
            if (n < 3) continue;
            masks.tangent1.emplace_back(edge, A * std::cos(i * angle));
            masks.tangent1.emplace_back(face, std::cos(i * angle) + std::cos((i + 1) * angle));
            masks.tangent2.emplace_back(edge, A * std::sin(i * angle));
            masks.tangent2.emplace_back(face, std::sin(i * angle) + std::sin((i + 1) * angle));
        }
        return masks;
    }
    if (m != 3) return masks;
    // At an end, in one direction: children (15, 1) / 16 and (11, 5) / 16 of p_0, p_1; the fixed point is (11, 1) / 12.
    if (shape.corner) {
        for (const FanLabel edge : {FanLabel{0, 1, 0}, FanLabel{1, 1, 0}}) add(edge, 11.0 / 144);
        add({}, 121.0 / 144);
        add({0, 1, 1}, 1.0 / 144);
        masks.lambda1 = masks.lambda2 = 0.25;
        return masks;
    }
    if (shape.boundary) {
        masks.lambda1 = 0.5;
        return masks;
    }
    for (int i = 0; i < n; ++i) {
        add({i, 0, 0}, 484.0 / (576 * n));
        add({i, 1, 0}, 88.0 / (2 * 576 * n));
        add({i, 0, 1}, 88.0 / (2 * 576 * n));
        add({i, 1, 1}, 4.0 / (576 * n));
    }
    return masks;
}

ClosedMasks biquartic_closed_masks(const FanShape& shape, const RuleOptions& options) {
    RuleOptions three = options;
    three.averaging_steps = 3;
    return averaging_closed_masks(shape, three);
}

namespace detail {

extern constinit const SchemeInfo biquartic_scheme{
    .name = "biquartic",
    .title = "Biquartic, Zorin, Schroeder 2001",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C3",
    .reproduction = 1,
    .generation = "bi-4",
    .lattice = FanLattice::dual,
    .rings = 2,
    .rule_rings = 2,
    .sees_rings = true,
    .step = biquartic_step,
    .closed_masks = biquartic_closed_masks,
    .notes = "any polygons; boundary by copies of its vertices, or the outer ring is used up; no creases",
    .averaging_steps = 3,
};

extern constinit const SchemeInfo averaging_scheme{
    .name = "averaging",
    .title = "Repeated averaging, m steps",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "Cm",
    .reproduction = 1,
    .generation = "bi-(m + 1)",
    .lattice = FanLattice::dual,
    .rings = 2,
    .rule_rings = 1,
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
