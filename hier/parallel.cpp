#include "tetrakis/hier/parallel.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <optional>

namespace tetrakis::detail {

void run_blocks(std::uint32_t count, std::uint32_t grain, void (*call)(const void*, std::uint32_t, std::uint32_t),
                const void* body) {
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::uint32_t>(0, count, grain),
                              [=](const auto& range) { call(body, range.begin(), range.end()); });
}

void run_in_arena(int threads, void (*call)(const void*), const void* work) {
    // The arena alone would be cut to the machine's processors, with a message from oneTBB. Where it is not, the limit
    // is left alone: to set and to reset it wakes the other threads.
    std::optional<oneapi::tbb::global_control> limit;
    if (threads > oneapi::tbb::this_task_arena::max_concurrency())
        limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    oneapi::tbb::task_arena arena(threads);
    arena.execute([=] { call(work); });
}

bool one_thread() { return oneapi::tbb::this_task_arena::max_concurrency() == 1; }

}  // namespace tetrakis::detail
