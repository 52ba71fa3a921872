#pragma once

#include "../../schemes/core/scheme_table.hpp"
#include "../rules/rule_limit.hpp"
#include "row_patterns.hpp"
#include "row_stars.hpp"

#include <cstdint>
#include <memory>
#include <vector>

namespace tetrakis::detail {

/// The rows of a scheme around each kind of corner of a net, and of their limits.
class StarLessons {
  public:
    /// @param net, corners, scheme  must live as long
    /// @param max_memory_bytes  what stars may take, estimated; 0: no limit
    StarLessons(const RootNet& net, const CornerKinds& corners, const SchemeInfo& scheme, const RuleOptions& rules,
                std::uint64_t max_memory_bytes);

    /// What the lessons of a step take at least, as so many points of a level by rules.
    static double cost(const CornerKinds& corners, const RootNet& net, const SchemeInfo& scheme,
                       const RuleOptions& rules, int factor);

    /// In stars as large as it takes; false where the rows do not repeat, or do so in too large stars only.
    /// @throws std::invalid_argument  as the scheme's step, and rule_limits()
    bool teach_step(RowPatterns& patterns);
    bool teach_limits(RowPatterns* points, RowPatterns* normals);

  private:
    bool too_large(std::uint32_t segments, std::uint32_t factor) const;
    /// The kinds' stars, and then a regular one.
    const std::vector<std::unique_ptr<RowStar>>& stars(std::uint32_t segments);

    const RootNet& net_;
    const CornerKinds& corners_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::uint64_t max_memory_bytes_;
    std::uint32_t segments_ = 0;
    std::vector<std::unique_ptr<RowStar>> stars_;
};

}  // namespace tetrakis::detail
