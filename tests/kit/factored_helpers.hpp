#pragma once

#include "point_match.hpp"
#include "random_mesh.hpp"

#include "../../refine/factored/factored_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

// What the tests of factored schemes share: meshes of given valences, and which vertices rules may read.
namespace tetrakis::test {

inline constexpr double k_agreement = 1e-12;  // of the bounding box: rounding of a few steps

inline ControlMesh build(std::vector<Vec3d> positions, const std::vector<std::vector<std::uint32_t>>& faces) {
    ControlMeshData data;
    data.positions = std::move(positions);
    data.face_offsets.push_back(0);
    for (const auto& f : faces) {
        data.face_vertices.insert(data.face_vertices.end(), f.begin(), f.end());
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
    return ControlMesh::build(std::move(data));
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

/// Largest distance of a point of either set from the other one, relative to the box. Same number of points.
inline double disagreement(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    REQUIRE(a.size() == b.size());
    double worst = 0;
    const PointMatch in_a(a), in_b(b);
    for (const Vec3d& p : a) worst = std::max(worst, glm::length(p - b[in_b.nearest(p)]));
    for (const Vec3d& p : b) worst = std::max(worst, glm::length(p - a[in_a.nearest(p)]));
    return worst / bounding_box(b).diagonal();
}

using Star = std::vector<std::uint32_t>;  ///< a vertex and its neighbours, in ascending order

inline std::vector<Star> stars(const FactoredMesh& mesh) {
    std::vector<Star> result(mesh.positions().size());
    for (std::uint32_t v = 0; v < result.size(); ++v) result[v].push_back(v);
    for (const auto& t : mesh.triangles())
        for (const std::uint32_t a : t)
            for (const std::uint32_t b : t)
                if (a != b) result[a].push_back(b);
    for (Star& star : result) {
        std::sort(star.begin(), star.end());
        star.erase(std::unique(star.begin(), star.end()), star.end());
    }
    return result;
}

inline bool includes(const Star& large, const std::set<std::uint32_t>& small) {
    return std::includes(large.begin(), large.end(), small.begin(), small.end());
}

/// Rules that look at the star of the block's centre, not only beside the new point.
inline bool needs_star_of_centre(FactoredScheme scheme) {
    return scheme == FactoredScheme::doo_sabin || scheme == FactoredScheme::midedge;
}

inline bool is_averaging(FactoredScheme scheme) {
    return scheme == FactoredScheme::averaging || scheme == FactoredScheme::biquartic;
}

/// Rules that look at the one-ring that was there before: 4-8's old vertices have moved by it, centres that become
/// points of an averaging rested at its mean.
inline bool needs_star_before(FactoredScheme scheme) {
    return scheme == FactoredScheme::four_eight || is_averaging(scheme);
}

/// Whether a vertex in the middle of a block reads the block's corners alone: they are the common neighbours of the two
/// that share the edge which it cuts.
inline bool reads_a_block(const std::vector<Star>& stars, const std::set<std::uint32_t>& reads) {
    for (const std::uint32_t x : stars[*reads.begin()])
        for (const std::uint32_t y : stars[x])
            if (y != x && includes(stars[x], reads) && includes(stars[y], reads)) return true;
    return false;
}

/// Without holes, which the schemes treat differently; without tags, inner vertices between two faces are rare as well
/// as left out.
inline ControlMesh random_surface(std::uint64_t seed, double tags) {
    RandomMeshOptions options = random_options(seed);
    options.hole = 0;
    options.boundary_rule = BoundaryRule::edge_and_corner;
    options.crease *= tags;
    options.corner *= tags;
    options.edge_vertices *= tags;
    return random_mesh(seed, options);
}

/// Runs half-steps and checks what their rules read.
inline void check_reads(FactoredMesh& mesh, FactoredScheme scheme, bool tags, int half_steps) {
    for (int i = 0; i < half_steps; ++i) {
        CAPTURE(i);
        auto before = stars(mesh);
        const std::size_t old_count = before.size();
        FactoredTrace trace;
        mesh.half_step(&trace);
        const auto after = stars(mesh);
        before.resize(after.size());
        std::vector<std::set<std::uint32_t>> reads(after.size());
        for (const auto& [computed, read] : trace.reads) reads[computed].insert(read);
        std::size_t computed = 0, outside = 0, through_centre = 0;
        for (std::uint32_t v = 0; v < after.size(); ++v) {
            if (reads[v].empty()) continue;
            ++computed;
            // The one-ring of the mesh that the half-step makes, or of the one before.
            if (includes(after[v], reads[v])) continue;
            if (needs_star_before(scheme) && includes(before[v], reads[v])) continue;
            bool found = false;
            // At creases a new vertex has copies of its old neighbours around it; at a boundary an average may have
            // lost some.
            if ((tags || is_averaging(scheme)) && *reads[v].rbegin() < old_count)
                found = reads_a_block(before, reads[v]);
            if (!found && needs_star_of_centre(scheme)) {
                for (const std::uint32_t c : after[v]) found |= includes(before[c], reads[v]);
                through_centre += found;
            }
            outside += !found;
        }
        CHECK(computed > 0);
        CHECK(outside == 0);
        if (i % 2 == 0) CHECK(through_centre == 0);
    }
}

}  // namespace tetrakis::test
