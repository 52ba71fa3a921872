#pragma once

#include "../../eval/surface/triangle_mesh.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/rules/polygon_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// Control meshes from lists of faces, from text and from data/; grids; comparison of meshes.
namespace tetrakis::test {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(static_cast<const void*>(a.data()), b.data(), a.size() * sizeof(T)) == 0);
}

inline ControlMeshData mesh_data(std::vector<Vec3d> positions, const std::vector<std::vector<std::uint32_t>>& faces) {
    ControlMeshData data;
    data.positions = std::move(positions);
    data.face_offsets = {0};
    for (const auto& face : faces) {
        data.face_vertices.insert(data.face_vertices.end(), face.begin(), face.end());
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
    return data;
}

/// A grid of n x n quads, or of twice as many triangles, between vertices at integers, row by row. As a torus its
/// opposite sides are joined: n x n vertices.
inline ControlMeshData grid(std::uint32_t n, bool triangles = false, bool torus = false) {
    const std::uint32_t side = torus ? n : n + 1;
    std::vector<Vec3d> positions;
    for (std::uint32_t y = 0; y < side; ++y)
        for (std::uint32_t x = 0; x < side; ++x) positions.emplace_back(x, y, 0);
    std::vector<std::vector<std::uint32_t>> faces;
    const auto at = [&](std::uint32_t x, std::uint32_t y) { return y % side * side + x % side; };
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t a = at(x, y), b = at(x + 1, y), c = at(x + 1, y + 1), d = at(x, y + 1);
            if (triangles) {
                faces.push_back({a, b, c});
                faces.push_back({a, c, d});
            } else {
                faces.push_back({a, b, c, d});
            }
        }
    return mesh_data(std::move(positions), faces);
}

/// Triangles around the z-axis, six at each of n x n vertices.
inline ControlMeshData triangle_torus(std::uint32_t n) {
    ControlMeshData data = grid(n, true, true);
    for (Vec3d& p : data.positions) {
        const double a = 2 * std::numbers::pi * p.y / n, b = 2 * std::numbers::pi * p.x / n;
        p = {(3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b)};
    }
    return data;
}

/// n x n quads over the unit square, with UVs equal to x and y.
inline ControlMeshData unit_sheet(std::uint32_t n) {
    ControlMeshData data = grid(n);
    for (Vec3d& p : data.positions) data.uvs.emplace_back(p /= n);
    data.face_uvs = data.face_vertices;
    return data;
}

inline Vec3d on_unit_circle(std::uint32_t i, std::uint32_t n, double z) {
    const double angle = 2 * std::numbers::pi * i / n;
    return {std::cos(angle), std::sin(angle), z};
}

/// A pyramid over an n-gon that is not flat.
inline ControlMeshData pyramid(std::uint32_t n) {
    std::vector<Vec3d> positions;
    std::vector<std::vector<std::uint32_t>> faces(n + 1);
    for (std::uint32_t i = 0; i < n; ++i) {
        positions.push_back(on_unit_circle(i, n, 0.2 * std::cos(6 * std::numbers::pi * i / n)));
        faces[i] = {i, (i + 1) % n, n};
        faces[n].push_back(n - 1 - i);
    }
    positions.emplace_back(0, 0, 1);
    return mesh_data(std::move(positions), faces);
}

/// The corners of each face.
inline std::vector<std::vector<std::uint32_t>> faces_of(const PolygonMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> faces;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        faces.emplace_back(mesh.face_vertices.begin() + mesh.face_offsets[f],
                           mesh.face_vertices.begin() + mesh.face_offsets[f + 1]);
    return faces;
}

/// The mesh itself, or cut into triangles if the scheme accepts triangles only.
inline ControlMesh mesh_for(const SchemeInfo& scheme, const ControlMesh& mesh) {
    return scheme.family == MeshFamily::triangles && !mesh.all_triangles() ? triangulate(mesh) : mesh;
}
/// @param text  contents of an OBJ file
inline ControlMesh mesh_for(const SchemeInfo& scheme, const std::string& text) {
    return mesh_for(scheme, ControlMesh::build(parse_obj(text, "test.obj")));
}
inline ControlMesh mesh_for(std::string_view scheme, const std::string& text) {
    return mesh_for(*find_scheme(scheme), text);
}

inline ControlMeshData model_data(const std::string& name) {
    return read_obj(std::string(TETRAKIS_SOURCE_DIR "/data/") + name + ".obj");
}
inline ControlMesh model(const std::string& name) { return ControlMesh::build(model_data(name)); }

}  // namespace tetrakis::test

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
    const tetrakis::ControlMeshData grid = tetrakis::test::grid(n, true);
    tetrakis::TriangleMesh mesh;
    for (const tetrakis::Vec3d& p : grid.positions) mesh.positions.emplace_back(p.x / n, p.y / n, z);
    for (std::size_t c = 0; c < grid.face_vertices.size(); c += 3)
        mesh.triangles.push_back({grid.face_vertices[c], grid.face_vertices[c + 1], grid.face_vertices[c + 2]});
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
