#pragma once

#include "../../schemes/core/scheme_table.hpp"
#include "../rules/rule_limit.hpp"
#include "corner_templates.hpp"
#include "row_patterns.hpp"

#include <cstdint>

namespace tetrakis::detail {

/// Least time for learning the rows of a step, in units of the time for one point of a level made by the rules.
double learning_cost(const CornerKinds& corners, const RootLattices& net, const SchemeInfo& scheme,
                     const RuleOptions& rules, int factor);

/// Scheme, net and kinds of corners whose stencil rows are to be learned. The scheme's rules give the rows on a
/// template of each kind (CornerTemplate); the process caches them for all meshes.
struct RowSource {
    const RootLattices& net;
    const CornerKinds& corners;
    const SchemeInfo& scheme;
    RuleOptions rules;
    std::uint64_t max_memory_bytes;  ///< limit on the estimated memory of the templates; 0: no limit
};
/// Learns the rows of one step from larger and larger templates. Returns false if the rows do not repeat, or if that
/// would need templates that are too large. @throws std::invalid_argument  as the scheme's step, and rule_limits()
bool learn_step(RowSource source, RowPatterns& patterns);
/// Learns the rows of limits in the same way. @param points, normals  receive the rows; null: not wanted
bool learn_limits(RowSource source, RowPatterns* points, RowPatterns* normals);

}  // namespace tetrakis::detail
