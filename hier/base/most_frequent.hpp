#pragma once

#include <algorithm>
#include <functional>
#include <vector>

namespace tetrakis::detail {

/// The value that is there most often, the least one of several. Sorts them; there is at least one.
template <class T>
T most_frequent(std::vector<T>& values) {
    // Mostly they are all the same.
    if (std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end()) return values[0];
    std::sort(values.begin(), values.end());
    T best = values[0];
    std::ptrdiff_t most = 0;
    for (auto at = values.begin(); at != values.end();) {
        const auto end = std::upper_bound(at, values.end(), *at);
        if (end - at > most) {
            most = end - at;
            best = *at;
        }
        at = end;
    }
    return best;
}

}  // namespace tetrakis::detail
