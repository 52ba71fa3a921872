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

/// The one of the build tree in whose folder tests/ this test is.
inline std::string program() {
    return (std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "tetrakis").string();
}

inline std::vector<std::string> command_line(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), program());
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

/// Runs it and checks that it ends with this code and a message that has these words, and prints nothing else.
inline std::string check_refused(const std::vector<std::string>& arguments, int code, const std::string& words) {
    CAPTURE(arguments);
    const ProcessResult result = run(arguments);
    CAPTURE(result.err);
    CHECK(result.code == code);
    CHECK(result.err.starts_with("tetrakis: error: "));
    CHECK(result.err.find(words) != std::string::npos);
    CHECK(result.out.empty());
    return result.err;
}

}  // namespace cli
