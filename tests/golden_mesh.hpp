#pragma once

#include "tetrakis/hier/vec.hpp"

#include <doctest/doctest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

// The golden files beside the project: what other libraries make of small control meshes.

inline std::string unzip(const std::filesystem::path& path) {
    gzFile file = gzopen(path.c_str(), "rb");
    REQUIRE(file != nullptr);
    std::string text;
    std::array<char, 1 << 16> buffer;
    for (int got; (got = gzread(file, buffer.data(), buffer.size())) > 0;)
        text.append(buffer.data(), static_cast<std::size_t>(got));
    gzclose(file);
    return text;
}

struct GoldenMesh {
    std::vector<tetrakis::Vec3d> points;
    std::vector<std::vector<std::uint32_t>> faces;
};

inline GoldenMesh read_golden(const std::filesystem::path& path) {
    GoldenMesh mesh;
    std::istringstream lines(unzip(path));
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") {
            tetrakis::Vec3d p;
            words >> p.x >> p.y >> p.z;
            mesh.points.push_back(p);
        } else if (kind == "f") {
            auto& face = mesh.faces.emplace_back();
            for (std::uint32_t v; words >> v;) face.push_back(v - 1);
        }
    }
    return mesh;
}

/// The same face whichever corner it starts from.
inline std::vector<std::uint32_t> rotated(std::vector<std::uint32_t> face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
}
