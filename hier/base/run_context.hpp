#pragma once

#include "error.hpp"

#include <cstdint>
#include <functional>
#include <string_view>

namespace tetrakis {

/// What every long call takes: how many threads, how much memory, and somebody to tell about progress.
struct RunContext {
    int threads = 0;                     ///< 0: as many as the machine has
    std::uint64_t max_memory_bytes = 0;  ///< 0: no limit
    /// Called between blocks of work, from the calling thread only; `fraction` is in [0, 1]. Returning false cancels:
    /// the running call then throws Error(cancelled) and leaves nothing half-written. May be empty.
    std::function<bool(std::string_view stage, double fraction)> progress;

    /// Reports progress; @throws Error cancelled when the callback asks for it.
    void report(std::string_view stage, double fraction) const {
        if (progress && !progress(stage, fraction)) throw Error(ErrorCode::cancelled, "cancelled");
    }
};

}  // namespace tetrakis
