#pragma once

#include <algorithm>
#include <any>
#include <chrono>
#include <functional>
#include <vector>

namespace tetrakis::bench {

/// Milliseconds that a call takes. What it returns is destroyed outside the time taken.
template <class Work>
double milliseconds(Work&& work) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    [[maybe_unused]] const auto result = work();
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

inline double median_of(std::vector<double> values) {
    const std::size_t n = values.size(), half = n / 2;
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half), values.end());
    if (n % 2) return values[half];
    return (values[half] + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half))) / 2;
}

/// The median of the milliseconds of `runs` calls.
template <class Work>
double median_ms(int runs, Work&& work) {
    std::vector<double> times;
    for (int run = 0; run < runs; ++run) times.push_back(milliseconds(work));
    return median_of(times);
}

/// Milliseconds of several works, [work][round]: they take turns, so that a busy spell of the machine meets all of
/// them. The first round warms up and does not count.
inline std::vector<std::vector<double>> milliseconds_in_turns(int rounds,
                                                              const std::vector<std::function<std::any()>>& works) {
    std::vector<std::vector<double>> times(works.size());
    for (int round = -1; round < rounds; ++round)
        for (std::size_t i = 0; i < works.size(); ++i) {
            const double ms = milliseconds(works[i]);
            if (round >= 0) times[i].push_back(ms);
        }
    return times;
}

/// The median over the rounds of what `a` takes beside `b`.
inline double median_ratio(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < a.size(); ++i) ratios.push_back(a[i] / b[i]);
    return median_of(ratios);
}

}  // namespace tetrakis::bench
