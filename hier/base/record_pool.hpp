#pragma once

#include <cstddef>
#include <memory>

namespace tetrakis::detail {

/// Memory for many small plain records that all live as long as the pool does. Any thread, without waiting for others:
/// each has blocks of its own, so that what two threads write does not share cache lines either.
class RecordPool {
  public:
    RecordPool();
    ~RecordPool();
    RecordPool(const RecordPool&) = delete;
    RecordPool& operator=(const RecordPool&) = delete;

    /// Aligned for all fundamental types. @throws std::bad_alloc
    void* allocate(std::size_t bytes);

  private:
    struct Threads;
    std::unique_ptr<Threads> threads_;
};

}  // namespace tetrakis::detail
