#pragma once

#include "../core/closed_masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis {

/// Dual schemes with one rule, as Doo-Sabin. Sources: Habib, Warren 1995; Peters, Reif 1997.
struct Midedge {
    /// (1 + 2 sum 2^(-j) cos(2 pi i j / k), 0 < j < k / 2) / k: eigenvalues 1 and 2^(-j) twice, so the subdominant ones
    /// are 1/2 for every k. The form follows from these properties (the sum starts at 1; printed sums start at 0).
    static std::vector<double> weights(int k);
    /// Two rounds of joining midpoints: 1/2, and 1/4 for either neighbour. Subdominant (1 + cos(2 pi / k)) / 2.
    static std::vector<double> weights_simplest(int k);
};

/// One step of each: detail::corner_weights_step().
RuleStep midedge_step(const RuleMesh& mesh, const RuleOptions& options);
RuleStep midedge_simplest_step(const RuleMesh& mesh, const RuleOptions& options);

/// detail::corner_weights_closed_masks().
ClosedMasks midedge_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks midedge_simplest_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
