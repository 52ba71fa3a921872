#include "../../schemes/core/scheme_table.hpp"

#include <doctest/doctest.h>

#include <set>
#include <string>

using namespace tetrakis;

namespace {

// Before main(), in whatever order the files are initialised.
const std::size_t k_length_of_notes = [] {
    std::size_t length = 0;
    for (const SchemeInfo& scheme : scheme_table()) length += scheme.notes.size();
    return length;
}();
const SchemeInfo* const k_last_at_start = find_scheme("honeycomb");

}  // namespace

TEST_SUITE_BEGIN("schemes");

TEST_CASE("the table is whole before the program starts, and its entries stay where they are") {
    std::size_t length = 0;
    std::set<std::string_view> names;
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        length += scheme.notes.size();
        CHECK(names.insert(scheme.name).second);
        CHECK(find_scheme(scheme.name) == &scheme);
        CHECK(nearest_scheme_name(scheme.name) == scheme.name);
        CHECK(bool(scheme.step));
        CHECK(bool(scheme.closed_masks));
    }
    CHECK(names.size() == scheme_table().size());
    CHECK(length == k_length_of_notes);
    REQUIRE(k_last_at_start != nullptr);
    CHECK(k_last_at_start == find_scheme("honeycomb"));
    CHECK(find_scheme("loops") == nullptr);
}

TEST_SUITE_END();
