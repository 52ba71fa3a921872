#include "../../hier/base/parallel.hpp"
#include "../../hier/base/error.hpp"
#include "../kit/input_helpers.hpp"

#include <doctest/doctest.h>

#include <cfenv>
#include <stdexcept>

using namespace tetrakis;
using test::with_thread_count;

TEST_SUITE_BEGIN("hier");

TEST_CASE("one thread is the calling thread, and arenas nest in any order") {
    const auto alone = [] { return detail::one_thread(); };
    CHECK(with_threads(with_thread_count(1), alone));
    CHECK(with_threads(with_thread_count(1), [&] { return with_threads(with_thread_count(1), alone); }));
    CHECK_FALSE(with_threads(with_thread_count(1), [&] { return with_threads(with_thread_count(2), alone); }));
    CHECK(with_threads(with_thread_count(1), [&] {
        return with_threads(with_thread_count(2), [&] { return with_threads(with_thread_count(1), alone); });
    }));
    CHECK_THROWS_AS(with_threads(with_thread_count(100'000), alone), Error);
    const auto fail = []() -> bool { throw std::runtime_error("on purpose"); };
    CHECK_THROWS_AS(with_threads(with_thread_count(1), fail), std::runtime_error);
    CHECK(with_threads(with_thread_count(1), alone));
}

TEST_CASE("loops round as the caller does") {
    const auto third = [] {
        double result = 0;
        with_threads(with_thread_count(1), [&] {
            for_each_index(
                4,
                [&](std::uint32_t i) {
                    const volatile double one = 1, three = 3;
                    if (i == 3) result = one / three;
                },
                1);
        });
        return result;
    };
    const double nearest = third();
    std::fesetround(FE_UPWARD);
    const double up = third();
    std::fesetround(FE_TONEAREST);
    CHECK(up > nearest);
    CHECK(third() == nearest);
}

TEST_SUITE_END();
