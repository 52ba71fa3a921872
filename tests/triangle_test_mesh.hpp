#pragma once

#include "tetrakis/hier/control_mesh.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis::test {

/// A random triangle mesh: a grid on the plane, a cylinder, a torus or a sphere with random diagonals, some faces taken
/// away (as long as all vertices stay manifold), some made holes, its faces in random order and rotation.
inline ControlMesh random_triangle_mesh(std::uint32_t seed) {
    using Triangle = std::array<std::uint32_t, 3>;
    std::mt19937 random(seed);
    const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    const std::uint32_t kind = seed % 4, columns = 3 + below(5), rows = 3 + below(5);
    const bool wraps_x = kind != 0, wraps_y = kind == 2;
    std::vector<Triangle> faces;
    const std::uint32_t width = wraps_x ? columns : columns + 1, height = wraps_y ? rows : rows + 1;
    std::uint32_t vertices = width * height;
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return x % width + width * (y % height); };
    for (std::uint32_t y = 0; y < rows; ++y)
        for (std::uint32_t x = 0; x < columns; ++x) {
            const std::uint32_t a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
            if (below(2)) {
                faces.push_back({a, b, c});
                faces.push_back({a, c, d});
            } else {
                faces.push_back({a, b, d});
                faces.push_back({b, c, d});
            }
        }
    if (kind == 3) {  // a sphere: the cylinder with both ends closed by fans
        const std::uint32_t south = vertices++, north = vertices++;
        for (std::uint32_t x = 0; x < columns; ++x) {
            faces.push_back({at(x + 1, 0), at(x, 0), south});
            faces.push_back({at(x, rows), at(x + 1, rows), north});
        }
    }
    std::shuffle(faces.begin(), faces.end(), random);

    // Fans of faces around each vertex; more than one would be a bow-tie.
    const auto is_manifold_around = [&](std::uint32_t v) {
        std::vector<std::pair<std::uint32_t, std::uint32_t>> spokes;  // each face leads from one neighbour to the next
        for (const Triangle& t : faces)
            for (std::uint32_t k = 0; k < 3; ++k)
                if (t[k] == v) spokes.emplace_back(t[(k + 1) % 3], t[(k + 2) % 3]);
        std::uint32_t starts = 0;
        for (const auto& s : spokes) {
            bool has_previous = false;
            for (const auto& p : spokes) has_previous |= p.second == s.first;
            starts += !has_previous;
        }
        return starts <= 1;
    };
    const std::uint32_t removals = seed % 3 == 0 ? 0 : below(static_cast<std::uint32_t>(faces.size()) / 3);
    for (std::uint32_t i = 0; i < removals; ++i) {
        const std::size_t place = below(static_cast<std::uint32_t>(faces.size()));
        const Triangle taken = faces[place];
        faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(place));
        bool is_manifold = true;
        for (const std::uint32_t v : taken) is_manifold &= is_manifold_around(v);
        if (!is_manifold) faces.push_back(taken);
    }

    ControlMeshData data;
    std::uniform_real_distribution<double> coordinate(-1, 1);
    for (std::uint32_t v = 0; v < vertices; ++v)
        data.positions.push_back({coordinate(random), coordinate(random), coordinate(random)});
    data.face_offsets.push_back(0);
    for (const Triangle& t : faces) {
        const std::uint32_t turn = below(3);
        for (std::uint32_t k = 0; k < 3; ++k) data.face_vertices.push_back(t[(k + turn) % 3]);
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        if (seed % 2 == 1 && below(12) == 0) data.holes.push_back(static_cast<std::uint32_t>(&t - faces.data()));
    }
    if (seed % 11 == 4) data.boundary_rule = BoundaryRule::none;
    return ControlMesh::build(std::move(data));
}

}  // namespace tetrakis::test
