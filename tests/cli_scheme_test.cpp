#include "tests/cli.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <set>
#include <string>

TEST_SUITE_BEGIN("cli");

TEST_CASE("schemes lists every scheme with its classification") {
    const nlohmann::json list = cli::run_json({"schemes", "--json"});
    const std::string text = cli::run({"schemes"}).out;
    std::set<std::string> names;
    for (const auto& scheme : list) {
        const std::string name = scheme.at("name");
        names.insert(name);
        CHECK(text.find("\n" + name + " ") != std::string::npos);
        CHECK(std::set<std::string>{"face split", "vertex split", "bisection", "sqrt3", "honeycomb"}.contains(
            scheme.at("refinement")));
        CHECK(scheme.at("interpolating").is_boolean());
    }
    for (const char* name : {"loop", "catmull-clark", "modified-butterfly", "kobbelt", "doo-sabin", "midedge",
                             "biquartic", "sqrt3", "4-8"})
        CHECK(names.contains(name));
    CHECK(names.size() == list.size());
}

TEST_CASE(
    "scheme explains every scheme, and what it prints as limit and tangents are left eigenvectors of its matrix") {
    for (const auto& listed : cli::run_json({"schemes", "--json"})) {
        const std::string name = listed.at("name");
        CAPTURE(name);
        CHECK(cli::run({"scheme", name}).code == 0);
        const nlohmann::json scheme = cli::run_json({"scheme", name, "--valence", "5", "--matrix", "--json"});
        const auto& matrix = scheme.at("matrix");
        const std::size_t size = matrix.size();
        CHECK(scheme.at("points").size() == size);
        CHECK(scheme.at("valence") == 5);
        const auto check = [&](const nlohmann::json& mask, double lambda) {
            if (mask.is_null()) return;
            const auto& weights = mask.at("weights");
            REQUIRE(weights.size() == size);
            double most = 0;
            for (std::size_t j = 0; j < size; ++j) {
                double sum = -lambda * weights[j].get<double>();
                for (std::size_t i = 0; i < size; ++i) sum += weights[i].get<double>() * matrix[i][j].get<double>();
                most = std::max(most, std::abs(sum));
            }
            CHECK(most < 1e-9);
        };
        check(scheme.at("limit"), 1);
        for (int i = 0; i < 2; ++i) check(scheme.at("tangents")[i], scheme.at("subdominant")[i]);
    }
    // The two-ring matrix of Loop's scheme has 3 v + 1 rows.
    CHECK(cli::run_json({"scheme", "loop", "--valence", "11", "--matrix", "--json"}).at("matrix").size() == 34);
    const nlohmann::json boundary = cli::run_json({"scheme", "loop", "--boundary", "--json"});
    CHECK(boundary.at("valence") == 4);
    CHECK(boundary.at("subdominant")[0].get<double>() == doctest::Approx(0.5));
    CHECK(cli::run({"scheme", "catmull-clark", "--valence", "7", "--matrix"}).out.find("unbounded") !=
          std::string::npos);
}

TEST_CASE("[bad-input] an unknown scheme is answered with the nearest name and all names") {
    const ProcessResult wrong = cli::run({"scheme", "catmul-clark"});
    CHECK(wrong.code == 2);
    CHECK(wrong.out.empty());
    CHECK(wrong.err.find("did you mean catmull-clark?") != std::string::npos);
    CHECK(wrong.err.find("modified-butterfly") != std::string::npos);
    CHECK(cli::run({"scheme"}).code == 2);
    CHECK(cli::run({"scheme", "loop", "--valence", "2"}).code == 2);
    CHECK(cli::run({"scheme", "loop", "--valence", "x"}).code == 2);
    CHECK(cli::run({"scheme", "honeycomb", "--boundary"}).code == 2);
    CHECK(cli::run({"scheme", "doo-sabin", "--boundary", "--valence", "4"}).code == 2);
}

TEST_SUITE_END();
