#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

// Reference data that lies beside the project: TETRAKIS_SHARED_DIR, or ../shared. Tests skip where it is absent.
namespace shared_data {

/// The folder `name` of the shared data; empty, with a message, where there is none.
inline std::optional<std::filesystem::path> folder(const std::string& name) {
    const char* given = std::getenv("TETRAKIS_SHARED_DIR");
    const std::filesystem::path root =
        given != nullptr ? std::filesystem::path(given) : std::filesystem::path(TETRAKIS_SOURCE_DIR) / ".." / "shared";
    const std::filesystem::path path = root / name;
    if (std::filesystem::is_directory(path)) return path;
    MESSAGE("skipped: there is no folder ", path.string(), " (set TETRAKIS_SHARED_DIR)");
    return std::nullopt;
}

/// Files of a folder that end in `suffix`, sorted.
inline std::vector<std::filesystem::path> files(const std::filesystem::path& folder, const std::string& suffix) {
    std::vector<std::filesystem::path> result;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().filename().string().ends_with(suffix)) result.push_back(entry.path());
    std::sort(result.begin(), result.end());
    return result;
}

}  // namespace shared_data
