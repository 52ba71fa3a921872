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
    return *std::ranges::max_element(values, {},
                                     [&](const T& value) { return std::ranges::equal_range(values, value).size(); });
}

}  // namespace tetrakis::detail
