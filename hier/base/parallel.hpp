#pragma once

#include "run_context.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

namespace tetrakis {

namespace detail {

using BlockBody = std::function<void(std::uint32_t begin, std::uint32_t end)>;

/// The one place that calls oneTBB for loops: for_each_block(), compiled once.
void run_blocks(std::uint32_t count, std::uint32_t grain, const BlockBody& body);
/// The same in batches, with a report before each.
void run_reported_blocks(std::uint32_t count, std::uint32_t grain, const RunContext& context, std::string_view stage,
                         double from, double to, const BlockBody& body);
/// Runs the work in an arena of `threads` threads; 0: in the arena of the caller.
void run_in_arena(int threads, const std::function<void()>& work);
/// Whether loops that are started here run on the calling thread alone.
bool one_thread();

}  // namespace detail

/// Elements below which a loop stays serial: starting a oneTBB loop costs a few microseconds.
inline constexpr std::uint32_t k_default_grain = 1024;

/// Calls body(begin, end) for disjoint ranges that cover [0, count), each about `grain` long.
template <class Body>
void for_each_block(std::uint32_t count, std::uint32_t grain, const Body& body) {
    detail::run_blocks(count, grain, std::cref(body));
}

/// Calls body(i) for each i in [0, count); serial below one grain. The body writes only what i owns.
template <class Body>
void for_each_index(std::uint32_t count, Body&& body, std::uint32_t grain = k_default_grain) {
    for_each_block(count, grain, [&body](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i != end; ++i) body(i);
    });
}

/// for_each_block in batches, with a report before each: `stage` goes from fraction `from` to `to`. Without a progress
/// callback it is for_each_block.
template <class Body>
void for_each_reported_block(std::uint32_t count, std::uint32_t grain, const RunContext& context,
                             std::string_view stage, double from, double to, const Body& body) {
    detail::run_reported_blocks(count, grain, context, stage, from, to, std::cref(body));
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
    if constexpr (std::is_void_v<Result>) {
        detail::run_in_arena(context.threads, std::ref(work));
    } else {
        std::optional<Result> result;
        detail::run_in_arena(context.threads, [&] { result.emplace(work()); });
        return std::move(*result);
    }
}

}  // namespace tetrakis
