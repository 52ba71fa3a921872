#pragma once

#include "tetrakis/hier/vec.hpp"

#include <array>
#include <cstdio>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

// Limit data of the reference folder: one line per level-2 vertex.
namespace tetrakis::test {

struct GoldenLimit {
    Vec3d position{0}, normal{0};  ///< normal 0: do not compare
    bool iterated = false;         ///< found by iteration: the normal is good to 2e-6
};

inline std::vector<GoldenLimit> read_golden_limits(const std::filesystem::path& path) {
    std::string text;
    FILE* pipe = popen(("gzip -dc '" + path.string() + "'").c_str(), "r");
    std::array<char, 65536> buffer;
    for (std::size_t n; pipe != nullptr && (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
        text.append(buffer.data(), n);
    if (pipe != nullptr) pclose(pipe);
    std::istringstream lines(text);
    std::vector<GoldenLimit> limits;
    bool iterated = false;
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#') {
            if (line.find("iterated ring") != std::string::npos) iterated = true;
            continue;
        }
        std::istringstream numbers(line);
        Vec3d level;
        GoldenLimit l;
        numbers >> level.x >> level.y >> level.z >> l.position.x >> l.position.y >> l.position.z >> l.normal.x >>
            l.normal.y >> l.normal.z;
        l.iterated = iterated;
        iterated = false;
        limits.push_back(l);
    }
    return limits;
}

}  // namespace tetrakis::test
