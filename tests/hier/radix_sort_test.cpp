#include "../../hier/base/radix_sort.hpp"

#include <doctest/doctest.h>

#include <random>
#include <utility>

using namespace tetrakis;

TEST_CASE("radix sort: the stable order, whatever bits differ") {
    using Item = std::pair<std::uint64_t, std::uint32_t>;
    std::mt19937_64 random(5);
    std::vector<Item> spare;
    for (const std::size_t count : {0u, 1u, 2u, 127u, 128u, 129u, 5000u})
        for (const std::uint64_t mask :
             {0ull, 1ull, 0xF0ull, 0xFFF0'0000'0000'0000ull, 0x8000'0000'0000'0001ull, ~0ull}) {
            CAPTURE(count);
            CAPTURE(mask);
            std::vector<Item> items(count);
            for (std::uint32_t i = 0; i < count; ++i)
                items[i] = {(random() & mask) | (0x0123'4567'89AB'CDEFull & ~mask), i};
            std::vector<Item> expected = items;
            std::sort(expected.begin(), expected.end());  // the second tells equal keys apart
            radix_sort(items, spare, [](const Item& item) { return item.first; });
            CHECK(items == expected);
            radix_sort(items, spare, [](const Item& item) { return item.first; });
            CHECK(items == expected);
        }
}
