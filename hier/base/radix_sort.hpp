#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace tetrakis {

/// Sorts by a 64-bit key; equal keys keep their order. Least significant digits first, a pass for about as many bits as
/// the number of items has (at most 12) between the lowest and the highest in which keys differ: keys that share most
/// bits cost little.
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
    // Digits of equal length; more counts than items would cost more than they save.
    constexpr int k_most = 12;
    const int lowest = std::countr_zero(differing), bits = std::bit_width(differing) - lowest;
    const int most = std::min(k_most, static_cast<int>(std::bit_width(items.size())));
    const int passes = (bits + most - 1) / most, digit = (bits + passes - 1) / passes;
    const std::size_t places = std::size_t{1} << digit;
    const std::uint64_t mask = places - 1;
    std::array<std::size_t, std::size_t{1} << k_most> place;
    for (int shift = lowest; shift < lowest + bits; shift += digit) {
        std::fill_n(place.begin(), places, std::size_t{0});
        for (const Item& item : items) ++place[key(item) >> shift & mask];
        std::size_t sum = 0;
        for (std::size_t d = 0; d < places; ++d) sum += std::exchange(place[d], sum);
        for (const Item& item : items) spare[place[key(item) >> shift & mask]++] = item;
        items.swap(spare);
    }
}

}  // namespace tetrakis
