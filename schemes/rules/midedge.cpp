#include "midedge.hpp"

#include "../core/corner_weights.hpp"
#include "../core/scheme_info.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

using std::numbers::pi;

std::vector<double> Midedge::weights(int k) {
    std::vector<double> w(k, 1.0 / k);
    for (int i = 0; i < k; ++i)
        for (int j = 1; 2 * j < k; ++j) w[i] += 2 * std::ldexp(std::cos(2 * pi * i * j / k), -j) / k;
    return w;
}

std::vector<double> Midedge::weights_simplest(int k) {
    std::vector<double> w(k, 0.0);
    w[0] += 0.5;
    w[1] += 0.25;
    w[k - 1] += 0.25;
    return w;
}

RuleStep midedge_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, Midedge::weights);
}
RuleStep midedge_simplest_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, Midedge::weights_simplest);
}

ClosedMasks midedge_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, 0.5);
}
ClosedMasks midedge_simplest_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, (1 + std::cos(2 * pi / shape.faces)) / 2);
}

namespace detail {

extern constinit const SchemeInfo midedge_scheme{
    .name = "midedge",
    .title = "Midedge, Habib, Warren 1995",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = midedge_step,
    .closed_masks = midedge_closed_masks,
    .notes = "any polygons; boundary and creases as doo-sabin; subdominant 1/2 for every face",
};

extern constinit const SchemeInfo midedge_simplest_scheme{
    .name = "midedge-simplest",
    .title = "Midedge, Peters, Reif 1997",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = midedge_simplest_step,
    .closed_masks = midedge_simplest_closed_masks,
    .notes = "any polygons; two rounds of joining midpoints",
};

}  // namespace detail
}  // namespace tetrakis
