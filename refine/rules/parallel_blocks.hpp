#pragma once

#include "../../hier/base/parallel.hpp"
#include "../../schemes/core/block_runner.hpp"

#include <cstdint>
#include <functional>

namespace tetrakis::detail {

/// Blocks of a step's rows on all threads.
class ParallelBlocks final : public BlockRunner {
  public:
    void run(int count, const std::function<void(int)>& block) const override {
        for_each_index(
            static_cast<std::uint32_t>(count), [&](std::uint32_t i) { block(static_cast<int>(i)); }, 1);
    }
    bool is_parallel() const override { return !one_thread(); }
};

}  // namespace tetrakis::detail
