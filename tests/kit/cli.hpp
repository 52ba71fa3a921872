#pragma once

#include "process.hpp"
#include "scratch_dir.hpp"

#include <doctest/doctest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// Runs the program that was built.
namespace cli {

inline std::vector<std::string> command_line(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), TETRAKIS_CLI);
    return arguments;
}

inline ProcessResult run(const std::vector<std::string>& arguments) { return run_process(command_line(arguments)); }

/// Runs it and gives what it printed as JSON; anything but success is a failed test.
inline nlohmann::json run_json(const std::vector<std::string>& arguments) {
    const ProcessResult result = run(arguments);
    CAPTURE(result.err);
    REQUIRE(result.code == 0);
    return nlohmann::json::parse(result.out);
}

inline std::string data(const std::string& name) { return std::string(TETRAKIS_SOURCE_DIR) + "/data/" + name; }

inline std::vector<std::string> data_models() {
    std::vector<std::string> models;
    for (const auto& entry : std::filesystem::directory_iterator(data("")))
        if (entry.path().extension() == ".obj") models.push_back(entry.path().string());
    std::sort(models.begin(), models.end());
    return models;
}

/// Checks that a report has exactly the keys that are documented, with the types that are documented, and perhaps more.
inline void check_report(const nlohmann::json& report) {
    using Kind = nlohmann::json::value_t;
    const auto check = [](const nlohmann::json& object, const std::string& key, bool may_be_null,
                          std::vector<Kind> kinds) {
        CAPTURE(key);
        REQUIRE(object.contains(key));
        if (may_be_null) kinds.push_back(Kind::null);
        CHECK(std::count(kinds.begin(), kinds.end(), object.at(key).type()) == 1);
    };
    for (const char* key : {"input", "scheme", "version"}) check(report, key, false, {Kind::string});
    for (const char* key : {"faces", "vertices", "levels", "peak_memory_bytes", "threads"})
        check(report, key, false, {Kind::number_unsigned});
    check(report, "triangles", true, {Kind::number_unsigned});
    for (const char* key : {"tolerance", "tolerance_absolute", "certified_error"})
        check(report, key, true, {Kind::number_float});
    check(report, "measured_error", true, {Kind::object});
    if (!report.at("measured_error").is_null()) {
        CHECK(report.at("measured_error").size() == 5);
        for (const char* key : {"forward", "backward", "hausdorff", "mean", "rms"})
            check(report.at("measured_error"), key, false, {Kind::number_float});
    }
    check(report, "seconds", false, {Kind::object});
    CHECK(report.at("seconds").size() == 6);
    for (const char* key : {"load", "build", "refine", "estimate", "measure", "write"}) {
        check(report.at("seconds"), key, false, {Kind::number_float});
        CHECK(report.at("seconds").at(key).get<double>() >= 0);
    }
    check(report, "warnings", false, {Kind::array});
    CHECK(report.at("peak_memory_bytes").get<std::uint64_t>() > 1'000'000);
    CHECK(report.at("threads").get<int>() >= 1);
}

}  // namespace cli
