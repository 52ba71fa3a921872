#pragma once

#include "../../schemes/core/scheme_table.hpp"
#include "../rules/rule_limit.hpp"
#include "corner_templates.hpp"
#include "row_patterns.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// The rows of a scheme around each kind of corner of the lattices, and those of their limits. The process keeps what
/// the rules have said of a kind, for all meshes that have it.
class RowLearner {
  public:
    /// @param net, corners, scheme  must live as long
    /// @param max_memory_bytes  what templates may take, estimated; 0: no limit
    RowLearner(const RootLattices& net, const CornerKinds& corners, const SchemeInfo& scheme, const RuleOptions& rules,
               std::uint64_t max_memory_bytes);

    /// What learning the rows of a step takes at least, as so many points of a level by rules.
    static double cost(const CornerKinds& corners, const RootLattices& net, const SchemeInfo& scheme,
                       const RuleOptions& rules, int factor);

    /// In templates as large as it takes; false where the rows do not repeat, or do so in too large templates only.
    /// @throws std::invalid_argument  as the scheme's step, and rule_limits()
    bool learn_step(RowPatterns& patterns);
    bool learn_limits(RowPatterns* points, RowPatterns* normals);

  private:
    bool too_large(std::uint32_t segments, std::uint32_t factor) const;
    std::shared_ptr<const CornerRows> step_rows(const CornerKind& kind, std::uint32_t segments) const;
    std::shared_ptr<const CornerRows> limit_rows(const CornerKind& kind, std::uint32_t segments);
    /// Of all kinds, and then of a regular corner; null where a finer level is no lattice.
    using Sources = std::vector<std::shared_ptr<const CornerRows>>;
    Sources rows(std::uint32_t segments, bool limits);
    template <class Learn>
    bool learn_from_templates(bool limits, const Learn& learn);

    const RootLattices& net_;
    const CornerKinds& corners_;
    const SchemeInfo& scheme_;
    RuleOptions rules_;
    std::uint64_t max_memory_bytes_;
    std::uint32_t factor_;
    std::optional<LimitSearch> search_;
};

}  // namespace tetrakis::detail
