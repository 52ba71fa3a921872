#pragma once

#include "../../eval/surface/triangle_mesh.hpp"

#include <cmath>
#include <numbers>

// Triangle meshes with known geometry, for tests.
namespace shapes {

/// Unit octahedron, corners on the axes.
inline tetrakis::TriangleMesh octahedron() {
    tetrakis::TriangleMesh mesh;
    mesh.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    return mesh;
}

/// Unit square at height z, cut into 2 n^2 triangles.
inline tetrakis::TriangleMesh square(double z, std::uint32_t n) {
    tetrakis::TriangleMesh mesh;
    for (std::uint32_t y = 0; y <= n; ++y)
        for (std::uint32_t x = 0; x <= n; ++x) mesh.positions.push_back({double(x) / n, double(y) / n, z});
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t v = y * (n + 1) + x;
            mesh.triangles.push_back({v, v + 1, v + n + 2});
            mesh.triangles.push_back({v, v + n + 2, v + n + 1});
        }
    return mesh;
}

/// Latitude-longitude sphere with unit normals; the poles are single vertices.
inline tetrakis::TriangleMesh sphere(std::uint32_t rings, std::uint32_t sectors, tetrakis::Vec3d centre,
                                     double radius) {
    tetrakis::TriangleMesh mesh;
    const auto add = [&](const tetrakis::Vec3d& normal) {
        mesh.normals.push_back(normal);
        mesh.positions.push_back(centre + radius * normal);
    };
    add({0, 0, 1});
    for (std::uint32_t r = 1; r < rings; ++r)
        for (std::uint32_t s = 0; s < sectors; ++s) {
            const double theta = std::numbers::pi * r / rings, phi = 2 * std::numbers::pi * s / sectors;
            add({std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
        }
    add({0, 0, -1});
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    const auto at = [&](std::uint32_t r, std::uint32_t s) { return 1 + (r - 1) * sectors + s % sectors; };
    for (std::uint32_t s = 0; s < sectors; ++s) {
        mesh.triangles.push_back({0, at(1, s), at(1, s + 1)});
        for (std::uint32_t r = 1; r + 1 < rings; ++r) {
            mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
            mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
        }
        mesh.triangles.push_back({at(rings - 1, s), last, at(rings - 1, s + 1)});
    }
    return mesh;
}

}  // namespace shapes
