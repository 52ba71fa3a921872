#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

namespace tetrakis::bench {

/// Milliseconds that a call takes: the median of `runs` calls. What it returns is destroyed outside the time taken.
template <class Work>
double median_ms(int runs, Work&& work) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> times;
    for (int run = 0; run < runs; ++run) {
        const auto start = Clock::now();
        [[maybe_unused]] const auto result = work();
        times.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    }
    std::nth_element(times.begin(), times.begin() + runs / 2, times.end());
    return times[runs / 2];
}

}  // namespace tetrakis::bench
