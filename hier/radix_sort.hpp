#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace tetrakis {

/// Sorts by a 64-bit key; equal keys keep their order. Least significant digits first, a pass for every 11 bits between
/// the lowest and the highest in which keys differ: keys that share most bits cost little.
/// @param items  std::vector or detail::PodArray
/// @param spare  working memory that is kept between calls
/// @param key    key(item) -> std::uint64_t, cheap: it is called in every pass
/// O(items x differing bits), one thread.
template <class Items, class Key>
void radix_sort(Items& items, Items& spare, const Key& key) {
    using Item = std::remove_cvref_t<decltype(items[0])>;
    constexpr std::size_t k_few = 128;
    if (items.size() < k_few) {
        std::stable_sort(items.begin(), items.end(), [&](const Item& a, const Item& b) { return key(a) < key(b); });
        return;
    }
    constexpr int k_digit = 11;
    constexpr std::uint64_t k_mask = (std::uint64_t{1} << k_digit) - 1;
    const std::uint64_t first = key(items[0]);
    std::uint64_t differing = 0, before = first;
    bool sorted = true;
    for (const Item& item : items) {
        const std::uint64_t k = key(item);
        differing |= k ^ first;
        sorted &= before <= k;
        before = k;
    }
    if (sorted) return;
    spare.resize(items.size());
    std::array<std::size_t, k_mask + 1> place;
    for (int shift = std::countr_zero(differing); shift < 64 && differing >> shift != 0; shift += k_digit) {
        place.fill(0);
        for (const Item& item : items) ++place[key(item) >> shift & k_mask];
        std::size_t sum = 0;
        for (std::size_t& p : place) {
            const std::size_t count = p;
            p = sum;
            sum += count;
        }
        for (const Item& item : items) spare[place[key(item) >> shift & k_mask]++] = item;
        items.swap(spare);
    }
}

}  // namespace tetrakis
