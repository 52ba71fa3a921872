#include "parallel.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <cfenv>
#include <optional>

#if defined(__SSE2__)
#    include <immintrin.h>
#endif

namespace tetrakis::detail {

void run_blocks(std::uint32_t count, std::uint32_t grain, void (*call)(const void*, std::uint32_t, std::uint32_t),
                const void* body) {
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::uint32_t>(0, count, grain),
                              [=](const auto& range) { call(body, range.begin(), range.end()); });
}

namespace {

// How this thread rounds, and what it does with subnormal numbers.
unsigned floating_point_settings() {
#if defined(__SSE2__)
    constexpr unsigned k_settings = 0xE040;  // rounding, flush to zero, denormals are zero
    return _mm_getcsr() & k_settings;
#else
    return static_cast<unsigned>(std::fegetround());
#endif
}

// An arena of the calling thread alone. Arenas work by the settings that they were made with.
struct KeptArena {
    oneapi::tbb::task_arena arena{1};
    unsigned settings = floating_point_settings();
    bool entered = false;

    void execute(void (*call)(const void*), const void* work) {
        if (const unsigned now = floating_point_settings(); now != settings) {
            arena.terminate();
            arena.initialize(1);
            settings = now;
        }
        const struct Entry {
            bool& entered;
            ~Entry() { entered = false; }
        } entry{entered};
        entered = true;
        arena.execute([=] { call(work); });
    }
};

}  // namespace

bool one_thread() { return oneapi::tbb::this_task_arena::max_concurrency() == 1; }

void run_in_arena(int threads, void (*call)(const void*), const void* work) {
    if (threads == 1) {
        if (one_thread()) return call(work);
        // To make an arena takes longer than small meshes do: each thread keeps one. It has room for one entry only.
        thread_local KeptArena kept;
        if (!kept.entered) return kept.execute(call, work);
    }
    // The arena alone would be cut to the machine's processors, with a message from oneTBB. Where it is not, the limit
    // is left alone: to set and to reset it wakes the other threads.
    std::optional<oneapi::tbb::global_control> limit;
    if (threads > oneapi::tbb::this_task_arena::max_concurrency())
        limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    oneapi::tbb::task_arena arena(threads);
    arena.execute([=] { call(work); });
}

}  // namespace tetrakis::detail
