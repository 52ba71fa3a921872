#pragma once

#include "run_context.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>

namespace tetrakis {

namespace detail {

/// The one place that calls oneTBB for loops: `call(body, begin, end)` for blocks of about `grain` that cover
/// [0, count).
void run_blocks(std::uint32_t count, std::uint32_t grain, void (*call)(const void*, std::uint32_t, std::uint32_t),
                const void* body);
/// call(work) in an arena of `threads` threads.
void run_in_arena(int threads, void (*call)(const void*), const void* work);
/// Whether what is called from here runs on the calling thread alone.
bool one_thread();

}  // namespace detail

/// Elements below which a loop stays serial: starting a oneTBB loop costs a few microseconds.
inline constexpr std::uint32_t k_default_grain = 1024;

/// Calls body(begin, end) for disjoint ranges that cover [0, count), each about `grain` long.
template <class Body>
void for_each_block(std::uint32_t count, std::uint32_t grain, Body&& body) {
    if (count <= grain) {
        if (count > 0) body(std::uint32_t{0}, count);
        return;
    }
    const auto call = [&body](std::uint32_t begin, std::uint32_t end) { body(begin, end); };
    detail::run_blocks(
        count, grain,
        [](const void* erased, std::uint32_t begin, std::uint32_t end) {
            (*static_cast<const decltype(call)*>(erased))(begin, end);
        },
        &call);
}

/// Calls body(i) for each i in [0, count); serial below one grain. The body writes only what i owns.
template <class Body>
void for_each_index(std::uint32_t count, Body&& body, std::uint32_t grain = k_default_grain) {
    for_each_block(count, grain, [&body](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i != end; ++i) body(i);
    });
}

namespace detail {

/// Reports the same fraction again from within a loop where a moment has passed, so that a few slow elements can be
/// cancelled. Other threads than the one that made it stay silent.
class RepeatedReport {
  public:
    RepeatedReport(const RunContext& context, std::string_view stage, double fraction)
        : context_(context), stage_(stage), fraction_(fraction) {}
    void operator()() {
        if (std::this_thread::get_id() != thread_) return;
        constexpr auto k_moment = std::chrono::milliseconds(50);
        const auto now = std::chrono::steady_clock::now();
        if (now - last_ < k_moment) return;
        context_.report(stage_, fraction_);
        last_ = now;
    }

  private:
    const RunContext& context_;
    std::string_view stage_;
    double fraction_;
    std::thread::id thread_ = std::this_thread::get_id();
    std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace detail

/// for_each_block in batches, with a report before each: `stage` goes from fraction `from` to `to`. Without anybody to
/// report to it is for_each_block.
template <class Body>
void for_each_reported_block(std::uint32_t count, std::uint32_t grain, const RunContext& context,
                             std::string_view stage, double from, double to, Body&& body) {
    if (!context.progress) return for_each_block(count, grain, std::forward<Body>(body));
    constexpr std::uint32_t k_batches = 64, k_grains = 16;
    const std::uint64_t batch = std::max<std::uint64_t>(count / k_batches + 1, std::uint64_t{k_grains} * grain);
    for (std::uint64_t begin = 0; begin < count; begin += batch) {
        const double fraction = from + (to - from) * static_cast<double>(begin) / count;
        context.report(stage, fraction);
        detail::RepeatedReport again(context, stage, fraction);
        const auto first = static_cast<std::uint32_t>(begin);
        for_each_block(static_cast<std::uint32_t>(std::min<std::uint64_t>(batch, count - begin)), grain,
                       [&](std::uint32_t b, std::uint32_t e) {
                           again();
                           body(first + b, first + e);
                       });
    }
    context.report(stage, to);
}

/// for_each_index with the same reports.
template <class Body>
void for_each_reported(std::uint32_t count, std::uint32_t grain, const RunContext& context, std::string_view stage,
                       double from, double to, Body&& body) {
    for_each_reported_block(count, grain, context, stage, from, to, [&body](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i != end; ++i) body(i);
    });
}

/// Runs `work` with the context's number of threads (an arena of its own; 1 means the calling thread alone).
template <class Work>
auto with_threads(const RunContext& context, Work&& work) {
    using Result = std::decay_t<decltype(work())>;
    if (context.threads <= 0) return work();
    const auto run = [&context](const auto& call) {
        detail::run_in_arena(
            context.threads, [](const void* erased) { (*static_cast<decltype(&call)>(erased))(); }, &call);
    };
    if constexpr (std::is_void_v<Result>) {
        run([&work] { work(); });
    } else {
        std::optional<Result> result;
        run([&work, &result] { result.emplace(work()); });
        return std::move(*result);
    }
}

}  // namespace tetrakis
