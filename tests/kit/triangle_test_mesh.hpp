#pragma once

#include "random_mesh.hpp"

#include <array>
#include <random>

namespace tetrakis::test {

/// random_mesh() with triangles only, and up to a third of its faces taken out (where the rest stays a manifold).
inline ControlMesh random_triangle_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.triangles_only = true;
    if (seed % 3 != 0) options.removed_faces = static_cast<int>(Random(seed).below(20));
    return random_mesh(seed, options);
}

/// random_triangle_mesh() with random creases, corners and crease method.
inline ControlMesh random_tagged_mesh(std::uint32_t seed) {
    const ControlMesh plain = random_triangle_mesh(seed);
    ControlMeshData data = plain.data();
    std::mt19937 random(seed * 7919u + 1);
    const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
    constexpr std::array<float, 6> values{10.0f, 0.4f, 1.0f, 1.5f, 2.3f, 10.0f};
    if (seed % 5 != 0) {
        for (std::uint32_t e = 0; e < plain.edge_count(); ++e) {
            const HalfedgeId h = plain.edge_halfedge(EdgeId(e));
            if (below(6) == 0) data.creases.push_back({plain.origin(h).value, plain.target(h).value, values[below(6)]});
        }
        for (std::uint32_t v = 0; v < plain.vertex_count(); ++v)
            if (!plain.is_isolated(VertexId(v)) && below(12) == 0) data.corners.push_back({v, values[below(6)]});
    }
    if (seed % 2 == 0) data.crease_method = CreaseMethod::chaikin;
    if (seed % 3 == 1) data.boundary_rule = BoundaryRule::edge_only;
    return ControlMesh::build(std::move(data));
}

}  // namespace tetrakis::test
