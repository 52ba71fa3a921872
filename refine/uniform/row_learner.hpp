#pragma once

#include "../../schemes/core/scheme_table.hpp"
#include "../rules/rule_limit.hpp"
#include "corner_templates.hpp"
#include "row_patterns.hpp"

#include <cstdint>

namespace tetrakis::detail {

/// What learning the rows of a step takes at least, as so many points of a level by rules.
double learning_cost(const CornerKinds& corners, const RootLattices& net, const SchemeInfo& scheme,
                     const RuleOptions& rules, int factor);

/// The rows of a scheme around each kind of corner of lattices, from what the rules say of it in a template. The
/// process keeps that for all meshes that have the kind.
struct RowSource {
    const RootLattices& net;
    const CornerKinds& corners;
    const SchemeInfo& scheme;
    RuleOptions rules;
    std::uint64_t max_memory_bytes;  ///< what templates may take, estimated; 0: no limit
};
/// In templates as large as it takes; false where the rows do not repeat, or do so in too large templates only.
/// @throws std::invalid_argument  as the scheme's step, and rule_limits()
bool learn_step(RowSource source, RowPatterns& patterns);
/// The same of limits. @param points, normals  unless null
bool learn_limits(RowSource source, RowPatterns* points, RowPatterns* normals);

}  // namespace tetrakis::detail
