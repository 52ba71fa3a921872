#pragma once

#include <functional>

namespace tetrakis {

/// Runs the blocks of a step's rows, possibly in parallel. Schemes use no threads themselves; the caller passes a
/// runner. The result does not depend on it.
class BlockRunner {
  public:
    virtual ~BlockRunner() = default;
    /// Calls block(i) for each i in [0, count), in any order and at the same time; throws what one of them throws.
    virtual void run(int count, const std::function<void(int)>& block) const = 0;
    /// Whether several blocks may run at the same time; if not, results can be appended directly.
    virtual bool is_parallel() const { return true; }
};

namespace detail {
inline constexpr int k_rows_per_block = 512;
}

}  // namespace tetrakis
