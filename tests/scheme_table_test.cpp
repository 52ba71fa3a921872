#include "tetrakis/schemes/scheme_table.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

// Before main(), in whatever order the files are initialised.
const std::size_t k_length_of_notes = [] {
    std::size_t length = 0;
    for (const SchemeInfo& scheme : scheme_table()) length += scheme.notes.size();
    return length;
}();
const SchemeInfo* const k_last_at_start = find_scheme("honeycomb");

std::string slurp(const std::filesystem::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

const std::filesystem::path k_schemes = std::filesystem::path(TETRAKIS_SOURCE_DIR) / "schemes";

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

TEST_CASE("a scheme is its file and its line: the list names it once, one file has its data, what lists them none") {
    std::istringstream list(slurp(k_schemes / "scheme_list.inc"));
    std::vector<std::string> listed;
    for (std::string line; std::getline(list, line);)
        if (const std::string head = "TETRAKIS_SCHEME("; line.starts_with(head))
            listed.push_back(line.substr(head.size(), line.find(')') - head.size()));
    REQUIRE(listed.size() == scheme_table().size());

    std::vector<std::pair<std::string, std::string>> sources;
    for (const auto& entry : std::filesystem::directory_iterator(k_schemes))
        if (entry.path().extension() == ".cpp") sources.emplace_back(entry.path().stem().string(), slurp(entry.path()));
    std::set<std::string> headers;
    auto name = listed.begin();
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        const std::string constant = "constinit const SchemeInfo " + *name++ + "_scheme{";
        const std::string first = ".name = \"" + std::string(scheme.name) + "\"";
        const auto has_data = [&](const auto& source) {
            const std::size_t at = source.second.find(constant);
            return at != std::string::npos && source.second.find(first, at) != std::string::npos;
        };
        REQUIRE(std::count_if(sources.begin(), sources.end(), has_data) == 1);
        headers.insert(std::find_if(sources.begin(), sources.end(), has_data)->first + ".hpp\"");
    }
    for (const auto& [file, text] : sources) {
        if (file != "scheme_table" && file != "local_matrix" && file != "spectrum" && file != "sector_fan") continue;
        CAPTURE(file);
        for (const std::string& header : headers) CHECK(text.find("/" + header) == std::string::npos);
    }
}

TEST_SUITE_END();
