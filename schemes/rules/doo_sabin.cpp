#include "doo_sabin.hpp"

#include "../core/corner_weights.hpp"
#include "../core/scheme_info.hpp"

#include <cmath>
#include <numbers>

namespace tetrakis {

using std::numbers::pi;

std::vector<double> DooSabin::weights(int k) {
    std::vector<double> w(k);
    for (int i = 0; i < k; ++i) w[i] = (3 + 2 * std::cos(2 * pi * i / k)) / (4 * k);
    w[0] = 0.25 + 5.0 / (4 * k);
    return w;
}

std::vector<double> DooSabin::weights_catmull_clark(int k) {
    std::vector<double> w(k, 1.0 / (4 * k));
    w[0] += 0.5;
    w[1] += 0.125;
    w[k - 1] += 0.125;
    return w;
}

RuleStep doo_sabin_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, DooSabin::weights);
}
RuleStep doo_sabin_catmull_clark_step(const RuleMesh& mesh, const RuleOptions& options) {
    return detail::corner_weights_step(mesh, options, DooSabin::weights_catmull_clark);
}

ClosedMasks doo_sabin_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, 0.5);
}
ClosedMasks doo_sabin_catmull_clark_closed_masks(const FanShape& shape, const RuleOptions&) {
    return detail::corner_weights_closed_masks(shape, 0.5 + std::cos(2 * pi / shape.faces) / 4);
}

namespace detail {

extern constinit const SchemeInfo doo_sabin_scheme{
    .name = "doo-sabin",
    .title = "Doo, Sabin 1978",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "bi-2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = doo_sabin_step,
    .closed_masks = doo_sabin_closed_masks,
    .notes = "any polygons; boundary as quadratic B-spline; a crease is a boundary on each side, corners stay",
};

extern constinit const SchemeInfo doo_sabin_catmull_clark_scheme{
    .name = "doo-sabin-cc",
    .title = "Doo-Sabin with the weights of Catmull, Clark 1978",
    .refinement = Refinement::vertex_split,
    .family = MeshFamily::quads,
    .interpolating = false,
    .smoothness = "C1",
    .reproduction = 1,
    .generation = "bi-2",
    .lattice = FanLattice::dual,
    .rings = 1,
    .rule_rings = 1,
    .sees_rings = true,
    .step = doo_sabin_catmull_clark_step,
    .closed_masks = doo_sabin_catmull_clark_closed_masks,
    .notes = "as doo-sabin; one averaging step",
};

}  // namespace detail
}  // namespace tetrakis
