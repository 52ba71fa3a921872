#pragma once

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// Removes the values that no corner names; the others keep their order.
template <class T>
void drop_unused(std::vector<std::uint32_t>& corners, std::vector<T>& values) {
    std::vector<std::uint32_t> number(values.size(), 0);
    for (const std::uint32_t v : corners) number[v] = 1;
    std::uint32_t count = 0;
    for (std::size_t v = 0; v < values.size(); ++v)
        if (number[v] != 0) {
            values[count] = values[v];
            number[v] = count++;
        }
    values.resize(count);
    for (std::uint32_t& v : corners) v = number[v];
}

}  // namespace tetrakis::detail
