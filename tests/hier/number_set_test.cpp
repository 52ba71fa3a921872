#include "../kit/random_mesh.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/number_set.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <set>
#include <utility>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("hier");

TEST_CASE("number sets: what std::set has, near numbers and far ones, inserted, erased and inserted again") {
    for (const std::uint64_t seed : test::seeds(4)) {
        CAPTURE(seed);
        test::Random random(seed);
        NumberSet set;
        std::set<std::uint64_t> expected;
        int wrong = 0;
        for (int i = 0; i < 20000; ++i) {
            const auto near = std::uint64_t{random.below(300)};
            // The largest that sqrt(3) refinement names lie below 2^64 / 9.
            const std::uint64_t number = random.chance(0.3) ? near * 0x5555'5555'5555ull : near;
            if (random.chance(0.5))
                wrong += set.insert(number) != expected.insert(number).second;
            else
                wrong += set.erase(number) != (expected.erase(number) == 1);
            wrong += set.contains(number) != (expected.count(number) == 1);
        }
        CHECK(wrong == 0);
        CHECK(set.size() == expected.size());
        CHECK(set.sorted() == std::vector<std::uint64_t>(expected.begin(), expected.end()));
        for (const std::uint64_t number : expected) CHECK(set.erase(number));
        CHECK(set.empty());
        CHECK(!set.contains(7));
    }
}

TEST_CASE("arrays keep their contents where they grow from the heap to pages of their own") {
    detail::PodArray<std::uint32_t> array;
    const auto value = [](std::size_t i) { return static_cast<std::uint32_t>(i * 2654435761u); };
    std::size_t size = 0;
    int wrong = 0;
    while (size < 6'000'000) {  // 24 MB
        const std::size_t before = size;
        size += size / 3 + 100'000;
        array.resize(size);
        for (std::size_t i = before; i < size; ++i) array[i] = value(i);
        for (std::size_t i = 0; i < size; i += 97) wrong += array[i] != value(i);
    }
    const detail::PodArray<std::uint32_t> copy = array, moved = std::move(array);
    for (std::size_t i = 0; i < size; ++i) wrong += copy[i] != value(i) || moved[i] != value(i);
    CHECK(wrong == 0);
    std::vector<double> filled;
    detail::resize_large(filled, 1'000'000);
    CHECK(filled == std::vector<double>(1'000'000, 0.0));
}

TEST_SUITE_END();
