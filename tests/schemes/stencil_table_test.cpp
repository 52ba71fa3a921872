#include "../../schemes/core/stencil_table.hpp"

#include <doctest/doctest.h>

#include <random>
#include <utility>

using namespace tetrakis;

TEST_SUITE_BEGIN("schemes");

TEST_CASE("tables one after the other: the same bits whether rows are sorted or summed in a row of all points") {
    constexpr int k_coarse = 90, k_middle = 60;
    for (const int terms : {1, 6, 40}) {  // of a row: few, some, and more than there are points
        CAPTURE(terms);
        std::mt19937 random(static_cast<unsigned>(terms));
        std::uniform_real_distribution<double> weight(-1, 1);
        const auto table = [&](int rows, int points) {
            StencilTable made;
            for (int r = 0; r < rows; ++r) {
                StencilRow row;
                for (int t = 0; t < terms; ++t) row.add(static_cast<int>(random() % points), weight(random));
                made.push(row);
            }
            return made;
        };
        const StencilTable coarse = table(k_middle, k_coarse);
        StencilTable fine = table(20, k_middle);
        StencilRow all;
        for (int v = 0; v < k_middle; ++v) all.add(v, 0.5);
        fine.push(all);
        const StencilTable both = coarse.then(fine);
        REQUIRE(both.row_count() == fine.row_count());
        for (int r = 0; r < fine.row_count(); ++r) {
            StencilRow expected;
            for (std::size_t i = 0; i < fine.points(r).size(); ++i)
                for (std::size_t k = 0; k < coarse.points(fine.points(r)[i]).size(); ++k)
                    expected.add(coarse.points(fine.points(r)[i])[k],
                                 fine.weights(r)[i] * coarse.weights(fine.points(r)[i])[k]);
            expected.gather();
            REQUIRE(both.points(r).size() == expected.terms.size());
            for (std::size_t i = 0; i < expected.terms.size(); ++i) {
                CHECK(both.points(r)[i] == expected.terms[i].first);
                CHECK(both.weights(r)[i] == expected.terms[i].second);
            }
        }
    }
    // Two equal rows that cancel each other, in as many terms as it takes.
    StencilTable coarse, fine;
    StencilRow row, difference;
    for (int p = 0; p < 200; ++p) row.add(p, 1.0 / (p + 1));
    for (int v = 0; v < 2; ++v) coarse.push(row);
    coarse.push({{3, 0.5}});
    for (const auto& [point, w] : {std::pair(0, 1.0), {1, -1.0}, {2, 2.0}}) difference.add(point, w);
    fine.push(difference);
    const StencilTable left = coarse.then(fine);
    REQUIRE(left.points(0).size() == 1);
    CHECK(left.points(0)[0] == 3);
    CHECK(left.weights(0)[0] == 1);
}

TEST_SUITE_END();
