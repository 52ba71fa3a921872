#pragma once

#include "../../hier/base/error.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tetrakis::test {

/// What refine() refuses within a limit of memory (0: none), before it has reported anything; nothing if it does not.
inline std::optional<ErrorCode> refused_first(const ControlMesh& mesh, std::string_view scheme, int levels,
                                              std::uint64_t limit) {
    RefineOptions options;
    options.context.max_memory_bytes = limit;
    bool started = false;
    options.context.progress = [&](std::string_view, double) { return started = true; };
    try {
        refine(mesh, scheme, levels, options);
    } catch (const Error& e) {
        CHECK(std::string(e.what()).find(std::to_string(levels) + " levels") != std::string::npos);
        CHECK_FALSE(started);
        return e.code();
    }
    return std::nullopt;
}

}  // namespace tetrakis::test
