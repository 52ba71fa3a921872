#pragma once

#include "../../hier/base/parallel.hpp"

#include <algorithm>
#include <cstdint>
#include <string_view>

namespace tetrakis::detail {

/// for_each_reported over what asks patches, in batches after each of which large trees are forgotten: some are grown
/// again, but memory does not grow with the number of irregular places. Batches are as long as what grows meanwhile
/// allows.
/// @param patches  null: none are asked
template <class Patches, class Body>
void for_each_batch(const Patches* patches, std::uint32_t count, std::uint32_t grain, const RunContext& context,
                    std::string_view stage, double from, double to, Body&& body) {
    if (!patches) return for_each_reported(count, grain, context, stage, from, to, std::forward<Body>(body));
    constexpr std::uint32_t k_reports = 64, k_grains = 16, k_least = 4;
    const std::uint32_t most = std::max(context.progress ? count / k_reports + 1 : count, k_grains * grain);
    std::uint32_t batch = k_least * grain;
    for (std::uint32_t begin = 0; begin < count;) {
        context.report(stage, from + (to - from) * begin / count);
        const std::uint64_t before = patches->forgettable_bytes();
        const std::uint32_t size = std::min(batch, count - begin);
        for_each_index(
            size, [&](std::uint32_t i) { body(begin + i); }, grain);
        begin += size;
        const std::uint64_t now = patches->forgettable_bytes();  // less than before where the body forgets trees
        const bool large = now > before && 4 * (now - before) > patches->bytes_to_keep();
        batch = large ? std::max(batch / 2, k_least * grain) : batch <= most / 2 ? 2 * batch : most;
        if (now > patches->bytes_to_keep()) patches->forget_trees();
    }
    context.report(stage, to);
}

}  // namespace tetrakis::detail
