#pragma once

#include "meshes.hpp"

#include "../../hier/mesh/control_mesh.hpp"

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

// Control meshes with angles at corners.
namespace tetrakis::test {

inline double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Calls visit(half-edges) for each sector at each corner. Corners are found by the tags and the boundary alone.
inline void for_each_sector(const ControlMesh& mesh, const std::function<void(const std::vector<HalfedgeId>&)>& visit) {
    const auto sharp = [&](HalfedgeId h) { return mesh.sharpness(mesh.edge(h)) > 0; };
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
        const HalfedgeId first = mesh.vertex_halfedge(VertexId(v));
        if (!first.valid()) continue;
        std::vector<HalfedgeId> ring;
        std::size_t start = 0;
        int edges = 0;
        for (HalfedgeId h = first;;) {
            if (sharp(h) && edges++ == 0) start = ring.size();
            ring.push_back(h);
            const HalfedgeId next = mesh.ccw_outgoing(h);
            if (!next.valid()) ++edges;
            if (!next.valid() || next == first) break;
            h = next;
        }
        if (!(mesh.sharpness(VertexId(v)) > 0) && edges < 3) continue;
        std::vector<HalfedgeId> sector;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const HalfedgeId h = ring[(start + i) % ring.size()];
            if (i > 0 && sharp(h)) {
                visit(sector);
                sector.clear();
            }
            sector.push_back(h);
        }
        visit(sector);
    }
}

/// The mesh with corner angles: `angle` returns the angle of a sector from its first half-edge, or nothing.
inline ControlMesh with_angles(const ControlMesh& mesh, const std::function<std::optional<double>(HalfedgeId)>& angle) {
    ControlMeshData data = mesh.data();
    for_each_sector(mesh, [&](const std::vector<HalfedgeId>& sector) {
        if (const auto a = angle(sector.front()))
            data.corner_angles.push_back({mesh.origin(sector.back()).value, mesh.face(sector.back()).value, *a});
    });
    return ControlMesh::build(std::move(data));
}

/// The mesh with pseudo-random convex and concave angles, which depend on the seed, at most of its sectors.
inline ControlMesh with_mixed_angles(const ControlMesh& mesh, std::uint64_t seed) {
    constexpr double k_degrees[] = {50, 90, 140, 200, 260, 300};
    return with_angles(mesh, [&](HalfedgeId h) -> std::optional<double> {
        const std::uint64_t at = (h.value * 2654435761u + seed * 40503u) >> 5 & 7;
        if (at >= std::size(k_degrees)) return std::nullopt;
        return radians(k_degrees[at]);
    });
}

/// sheet(): a hilly grid of 7 by 7 quads, or twice as many triangles, with texture coordinates. Vertex (x, y) is number
/// 8 y + x. It has two corners: k_straight on a crease along its row, with two quads on each side; and k_bent, where a
/// crease from the left turns down, with one quad on one side and three on the other.
inline constexpr std::uint32_t k_straight = 8 * 2 + 2, k_bent = 8 * 5 + 5;

inline ControlMesh sheet(bool triangles) {
    constexpr std::uint32_t k_side = 8;
    ControlMeshData data = grid(k_side - 1, triangles);
    for (Vec3d& p : data.positions) {
        p.z = std::sin(2.3 * p.x + 1.1 * p.y) * 0.6;
        data.uvs.emplace_back(p.x * p.x / 49.0, p.y / 7.0);
    }
    data.face_uvs = data.face_vertices;
    for (std::uint32_t x = 0; x < 4; ++x)
        data.creases.push_back({k_side * 2 + x, k_side * 2 + x + 1, k_infinite_sharpness});
    for (std::uint32_t i = 5; i < 7; ++i) {
        data.creases.push_back({k_side * 5 + i - 2, k_side * 5 + i - 1, k_infinite_sharpness});
        data.creases.push_back({k_side * (i - 2) + 5, k_side * (i - 1) + 5, k_infinite_sharpness});
    }
    for (const std::uint32_t v : {k_straight, k_bent}) data.corners.push_back({v, k_infinite_sharpness});
    return ControlMesh::build(std::move(data));
}

}  // namespace tetrakis::test
