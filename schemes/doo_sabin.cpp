#include "tetrakis/schemes/doo_sabin.hpp"

#include "tetrakis/schemes/corner_weights.hpp"

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

}  // namespace tetrakis
