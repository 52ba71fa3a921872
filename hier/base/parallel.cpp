#include "parallel.hpp"

#include "error.hpp"

#include <fmt/format.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <thread>
#include <vector>

namespace tetrakis::detail {

void run_blocks(std::uint32_t count, std::uint32_t grain, const BlockBody& body) {
    if (count == 0) return;
    if (count <= grain) return body(0, count);
#if defined(__SANITIZE_THREAD__)
    // ThreadSanitizer does not see how oneTBB's threads wait for each other, and would report every loop.
    std::atomic<std::uint64_t> next = 0;
    const auto run = [&] {
        for (std::uint64_t begin; (begin = next.fetch_add(grain)) < count;)
            body(static_cast<std::uint32_t>(begin),
                 static_cast<std::uint32_t>(std::min<std::uint64_t>(begin + grain, count)));
    };
    std::vector<std::future<void>> others;
    for (int i = 1; i < oneapi::tbb::this_task_arena::max_concurrency(); ++i)
        others.push_back(std::async(std::launch::async, run));
    run();
    for (std::future<void>& other : others) other.get();
#else
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::uint32_t>(0, count, grain),
                              [&](const auto& range) { body(range.begin(), range.end()); });
#endif
}

void run_reported_blocks(std::uint32_t count, std::uint32_t grain, const RunContext& context, std::string_view stage,
                         double from, double to, const BlockBody& body) {
    if (!context.progress) return run_blocks(count, grain, body);
    constexpr std::uint32_t k_batches = 64, k_grains = 16;
    constexpr auto k_moment = std::chrono::milliseconds(50);
    const std::uint64_t batch = std::max<std::uint64_t>(count / k_batches + 1, std::uint64_t{k_grains} * grain);
    for (std::uint64_t begin = 0; begin < count; begin += batch) {
        const double fraction = from + (to - from) * static_cast<double>(begin) / count;
        context.report(stage, fraction);
        // The calling thread repeats the report every k_moment, so that the user can cancel while a few elements are
        // slow.
        auto last = std::chrono::steady_clock::now();
        const auto run = [&, thread = std::this_thread::get_id(), first = static_cast<std::uint32_t>(begin)](
                             std::uint32_t b, std::uint32_t e) {
            if (std::this_thread::get_id() == thread) {
                const auto now = std::chrono::steady_clock::now();
                if (now - last >= k_moment) {
                    context.report(stage, fraction);
                    last = now;
                }
            }
            body(first + b, first + e);
        };
        for_each_block(static_cast<std::uint32_t>(std::min<std::uint64_t>(batch, count - begin)), grain, run);
    }
    context.report(stage, to);
}

bool one_thread() { return oneapi::tbb::this_task_arena::max_concurrency() == 1; }

void run_in_arena(int threads, const std::function<void()>& work) {
    constexpr int k_most_threads = 1024;
    if (threads < 0 || threads > k_most_threads)
        throw Error(ErrorCode::invalid_input,
                    fmt::format("{} threads; 0 (one a processor) to {} are possible", threads, k_most_threads));
    if (threads == 0 || (threads == 1 && one_thread())) return work();
    // Without this limit, oneTBB cuts a larger arena to the machine's processors and prints a message. For other arenas
    // the limit is not set, because setting and resetting it wakes the other threads.
    std::optional<oneapi::tbb::global_control> limit;
    if (threads > oneapi::tbb::this_task_arena::max_concurrency())
        limit.emplace(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    oneapi::tbb::task_arena arena(threads);
    arena.execute(work);
}

}  // namespace tetrakis::detail
