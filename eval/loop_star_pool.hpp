#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <vector>

namespace tetrakis::detail {

/// Memory for the many small stars of a patch tree, which all live as long as it does. Any thread.
class LoopStarPool {
  public:
    /// Aligned for doubles and pointers.
    void* allocate(std::size_t bytes) {
        const std::size_t units = (bytes + sizeof(Unit) - 1) / sizeof(Unit);
        const std::lock_guard lock(mutex_);
        if (units > left_) {
            left_ = units > k_block ? units : k_block;
            blocks_.push_back(std::make_unique_for_overwrite<Unit[]>(left_));
            next_ = blocks_.back().get();
        }
        Unit* const out = next_;
        next_ += units;
        left_ -= units;
        return out;
    }

  private:
    struct alignas(std::max_align_t) Unit {
        std::byte bytes[alignof(std::max_align_t)];
    };
    // 32 KiB: a hundred stars, and little to waste for a small mesh.
    static constexpr std::size_t k_block = 2048;
    std::mutex mutex_;
    std::vector<std::unique_ptr<Unit[]>> blocks_;
    Unit* next_ = nullptr;
    std::size_t left_ = 0;
};

}  // namespace tetrakis::detail
