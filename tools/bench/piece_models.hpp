#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

namespace tetrakis::bench {

/// A model of the project's own data folder.
inline ControlMesh data_model(const std::string& name) {
    return load_control_mesh(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / (name + ".obj"));
}

/// A torus of n x n quads: a control mesh of any size.
inline ControlMeshData torus(std::uint32_t n) {
    ControlMeshData data;
    data.face_offsets.push_back(0);
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const double a = 2 * std::numbers::pi * i / n, b = 2 * std::numbers::pi * j / n, r = 2 + std::cos(b);
            data.positions.emplace_back(r * std::cos(a), r * std::sin(a), std::sin(b));
            const std::uint32_t i1 = (i + 1) % n, j1 = (j + 1) % n;
            for (const std::uint32_t v : {i * n + j, i1 * n + j, i1 * n + j1, i * n + j1})
                data.face_vertices.push_back(v);
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        }
    return data;
}

}  // namespace tetrakis::bench
