#pragma once

#include <functional>

namespace tetrakis {

/// Who computes the rows of a step: schemes know no threads, so the caller hands in what runs blocks of them in
/// parallel. The result does not depend on it.
class BlockRunner {
  public:
    virtual ~BlockRunner() = default;
    /// Calls block(i) for each i in [0, count), in any order and at the same time; throws what one of them throws.
    virtual void run(int count, const std::function<void(int)>& block) const = 0;
    /// Whether several blocks may run at the same time; if not, results can be put together as they come.
    virtual bool is_parallel() const { return true; }
};

namespace detail {
inline constexpr int k_rows_per_block = 512;
}

}  // namespace tetrakis
