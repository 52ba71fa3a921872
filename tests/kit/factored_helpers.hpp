#pragma once

#include "nearest.hpp"
#include "random_mesh.hpp"

#include "../../refine/factored/factored_mesh.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

// Meshes of given valences, and comparisons, for the tests of factored schemes.
namespace tetrakis::test {

inline constexpr double k_agreement = 1e-12;  // of the bounding box's diagonal: rounding of a few steps

inline ControlMesh build(std::vector<Vec3d> positions, const std::vector<std::vector<std::uint32_t>>& faces) {
    return ControlMesh::build(mesh_data(std::move(positions), faces));
}

inline Vec3d on_circle(int i, int n, double radius, double z) {
    const double a = 2 * std::numbers::pi * i / n;
    return {radius * std::cos(a) + 0.1 * std::sin(5 * a + z), radius * std::sin(a), z + 0.2 * std::cos(3 * a)};
}

/// A prism: two n-gons and n quads, not symmetric.
inline ControlMesh prism(int n) {
    std::vector<Vec3d> positions;
    std::vector<std::vector<std::uint32_t>> faces(2);
    for (int i = 0; i < n; ++i) {
        positions.push_back(on_circle(i, n, 2, 0));
        positions.push_back(on_circle(i, n, 1.5, 2));
        const auto a = static_cast<std::uint32_t>(2 * i), b = static_cast<std::uint32_t>(2 * ((i + 1) % n));
        faces[0].insert(faces[0].begin(), a);
        faces[1].push_back(a + 1);
        faces.push_back({a, b, b + 1, a + 1});
    }
    return build(std::move(positions), faces);
}

/// Two vertices of valence n between quads: n vertices on an equator are joined to both poles, every other one lower.
inline ControlMesh double_fan(int n) {
    std::vector<Vec3d> positions{{0.1, 0, 2}, {0, 0.2, -2}};
    std::vector<std::vector<std::uint32_t>> faces;
    for (int i = 0; i < 2 * n; ++i) positions.push_back(on_circle(i, 2 * n, 2, i % 2 == 0 ? 0.5 : -0.5));
    for (int i = 0; i < n; ++i) {
        const auto at = [&](int j) { return static_cast<std::uint32_t>(2 + j % (2 * n)); };
        faces.push_back({0, at(2 * i), at(2 * i + 1), at(2 * i + 2)});
        faces.push_back({1, at(2 * i + 3), at(2 * i + 2), at(2 * i + 1)});
    }
    return build(std::move(positions), faces);
}

inline FactoredMesh factored(const ControlMesh& mesh, FactoredScheme scheme, int half_steps) {
    FactoredMesh result(mesh, scheme);
    for (int i = 0; i < half_steps; ++i) result.half_step();
    return result;
}

/// Hausdorff distance of two sets with as many points, relative to the diagonal of the second one's bounding box.
inline double disagreement(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    REQUIRE(a.size() == b.size());
    const PointMatch in_a(a), in_b(b);
    double worst = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        worst = std::max({worst, glm::length(a[i] - b[in_b.nearest(a[i])]), glm::length(b[i] - a[in_a.nearest(b[i])])});
    return worst / bounding_box(b).diagonal();
}

/// The points of a mesh, and the means of its faces' corners.
inline std::vector<Vec3d> points_and_means(const PolygonMesh& mesh) {
    std::vector<Vec3d> result = mesh.positions;
    for (const auto& face : faces_of(mesh)) {
        Vec3d sum(0);
        for (const std::uint32_t v : face) sum += mesh.positions[v];
        result.push_back(sum / double(face.size()));
    }
    return result;
}

/// disagreement() of the points and face centres after some factored steps with those of the scheme's rules. For 4-8
/// on a mesh with other faces than quads the first step is half a step.
inline double disagreement_with_rules(const ControlMesh& mesh, FactoredScheme scheme, int steps,
                                      const RuleOptions& rules = {}) {
    FactoredMesh ours(mesh, scheme, 0, rules);
    int half_steps = steps * ours.half_steps_per_level();
    if (scheme == FactoredScheme::four_eight)
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
            if (mesh.face_size(FaceId(f)) != 4) half_steps = steps * ours.half_steps_per_level() - 1;
    for (int i = 0; i < half_steps; ++i) ours.half_step();
    return disagreement(
        points_and_means(ours.active_mesh()),
        points_and_means(refine_stencils(mesh, scheme_named(name(scheme)), steps, {.rules = rules}).mesh));
}

/// A random mesh without holes, which the schemes treat differently. `tags` scales the chance of creases, of corners
/// and of added vertices of valence 2; merged faces can leave such vertices all the same.
inline ControlMesh random_surface(std::uint64_t seed, double tags) {
    RandomMeshOptions options = random_options(seed);
    options.hole = 0;
    options.boundary_rule = BoundaryRule::edge_and_corner;
    options.crease *= tags;
    options.corner *= tags;
    options.edge_vertices *= tags;
    return random_mesh(seed, options);
}

}  // namespace tetrakis::test
