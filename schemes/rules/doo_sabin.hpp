#pragma once

#include "../core/closed_masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis {

/// Dual schemes with one rule: the new corner of a k-gon from its k corners, from the corner itself on.
/// Sources: Doo, Sabin 1978; Catmull, Clark 1978 (their weights for it).
struct DooSabin {
    /// 1/4 + 5/(4k), then (3 + 2 cos(2 pi i / k)) / (4k). Eigenvalues of the k-gon: 1, 1/2 twice, 1/4.
    static std::vector<double> weights(int k);
    /// Catmull and Clark's: the corner 1/2, its neighbours 1/8, and 1/(4k) for all. Subdominant 1/2 + cos(2 pi / k)
    /// / 4.
    static std::vector<double> weights_catmull_clark(int k);
};

/// One step of each: detail::corner_weights_step().
RuleStep doo_sabin_step(const RuleMesh& mesh, const RuleOptions& options);
RuleStep doo_sabin_catmull_clark_step(const RuleMesh& mesh, const RuleOptions& options);

/// detail::corner_weights_closed_masks().
ClosedMasks doo_sabin_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks doo_sabin_catmull_clark_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
