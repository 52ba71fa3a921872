#pragma once

#include "../../hier/base/vec.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

// The files of tests/golden: what other libraries make of small control meshes. Its README says which, and how.
namespace golden {

/// tests/golden; empty, with the message that makes ctest count the case as skipped, where it is missing.
inline std::optional<std::filesystem::path> folder() {
    const std::filesystem::path path = std::filesystem::path(TETRAKIS_SOURCE_DIR) / "tests" / "golden";
    if (std::filesystem::is_directory(path)) return path;
    MESSAGE("SKIPPED: there is no folder ", path.string());
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

inline std::string unzip(const std::filesystem::path& path) {
    gzFile file = gzopen(path.c_str(), "rb");
    REQUIRE(file != nullptr);
    std::string text;
    std::array<char, 1 << 16> buffer;
    int got = 0;
    while ((got = gzread(file, buffer.data(), buffer.size())) > 0)
        text.append(buffer.data(), static_cast<std::size_t>(got));
    gzclose(file);
    REQUIRE(got == 0);
    REQUIRE(!text.empty());
    return text;
}

struct Mesh {
    std::vector<tetrakis::Vec3d> points;
    std::vector<std::vector<std::uint32_t>> faces;
};

/// "<mesh>.<scheme>.<library>.L<level>.obj.gz"
inline Mesh read_mesh(const std::filesystem::path& path) {
    Mesh mesh;
    std::istringstream lines(unzip(path));
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") {
            tetrakis::Vec3d p;
            words >> p.x >> p.y >> p.z;
            REQUIRE(!words.fail());
            mesh.points.push_back(p);
        } else if (kind == "f") {
            auto& face = mesh.faces.emplace_back();
            for (std::uint32_t v; words >> v;) face.push_back(v - 1);
        }
    }
    REQUIRE(!mesh.faces.empty());
    return mesh;
}

/// Of a vertex of level 2.
struct Limit {
    tetrakis::Vec3d at, position, normal;  ///< at level 2 and in the limit; no normal is known where it is zero
    bool iterated = false;                 ///< the normal is good to 2e-6
};

/// "<mesh>.<scheme>.osd.limit.txt.gz"
inline std::vector<Limit> read_limits(const std::filesystem::path& path) {
    std::vector<Limit> limits;
    bool iterated = false;
    std::istringstream lines(unzip(path));
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("#")) {
            iterated = line.find("next line by iterated ring refinement") != std::string::npos;
            continue;
        }
        std::istringstream words(line);
        Limit l;
        words >> l.at.x >> l.at.y >> l.at.z >> l.position.x >> l.position.y >> l.position.z >> l.normal.x >>
            l.normal.y >> l.normal.z;
        REQUIRE(!words.fail());
        l.iterated = iterated;
        iterated = false;
        limits.push_back(l);
    }
    REQUIRE(!limits.empty());
    return limits;
}

}  // namespace golden
