#include "../../eval/tessellate/tessellate.hpp"

#include "../kit/meshes.hpp"
#include "../kit/nearest.hpp"
#include "../kit/scheme_meshes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <vector>

using namespace tetrakis;
using test::mesh_for;

TEST_SUITE_BEGIN("eval");

namespace {

/// A warped cube with a pyramid on top, whose edge is infinitely sharp: a lid and a cup, each smooth up to there.
constexpr const char* k_cube =
    "v -1 -1 1.1\nv 1 -1 0.8\nv 1 1 1.3\nv -1 1 0.9\nv -1 -1 -1\nv 1.2 -1 -1\nv 1 1.1 -1\nv -1 1 -1\n"
    "v 0.1 0 1.6\n";
constexpr const char* k_lid = "f 1 2 9\nf 2 3 9\nf 3 4 9\nf 4 1 9\n";
constexpr const char* k_flat_lid = "f 1 2 3 4\n";  // all quads, for schemes that treat other faces apart
constexpr const char* k_cup = "f 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
constexpr const char* k_sharp_ring =
    "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 2 10\nt crease 2/1/0 2 3 10\nt crease 2/1/0 3 0 10\n";
/// Boundaries smooth at all vertices, as creases are.
constexpr const char* k_smooth_boundary = "t interpolateboundary 1/0/0 2\n";

double degrees_between(const Vec3d& a, const Vec3d& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi;
}

const Vec3d& corner_normal(const TriangleMesh& mesh, std::size_t t, std::size_t k) {
    return mesh.normals[mesh.triangle_normals.empty() ? mesh.triangles[t][k] : mesh.triangle_normals[t][k]];
}

double degrees_off(const TriangleMesh& mesh, std::size_t t, std::size_t k) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3d area = glm::cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    return glm::length(area) > 0 ? degrees_between(corner_normal(mesh, t, k), area) : 0;
}

double most_degrees_off(const TriangleMesh& mesh) {
    double most = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) most = std::max(most, degrees_off(mesh, t, k));
    return most;
}

/// How many vertices have more than one normal.
std::size_t split_vertices(const TriangleMesh& mesh) {
    std::vector<std::set<std::uint32_t>> normals(mesh.positions.size());
    for (std::size_t t = 0; t < mesh.triangle_normals.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) normals[mesh.triangles[t][k]].insert(mesh.triangle_normals[t][k]);
    return static_cast<std::size_t>(
        std::count_if(normals.begin(), normals.end(), [](const auto& of_vertex) { return of_vertex.size() > 1; }));
}

}  // namespace

TEST_CASE("a direction of any length has length one, and none where there is no finite one") {
    for (const double length : {1.0, 1e-310, 1e-200, 1e200, 1e307})
        CHECK(glm::distance(unit_or_zero(length * Vec3d(2, -1, 2)), Vec3d(2, -1, 2) / 3.0) < 1e-12);
    for (const double bad : {double{NAN}, double{INFINITY}})
        for (int axis = 0; axis < 3; ++axis) {
            Vec3d v(1, 2, 3);
            v[axis] = bad;
            CHECK(unit_or_zero(v) == Vec3d(0));
        }
    CHECK(unit_or_zero(Vec3d(0)) == Vec3d(0));
}

TEST_CASE("beside a crease each side has the limit normal of the surface that ends there") {
    struct Case {
        const char* scheme;
        const char* lid;
        std::uint32_t lid_faces;
        double degrees;           ///< of sides that are continued from their neighbours, by no limit of their own: more
        std::size_t at_ends = 0;  ///< vertices where a side ends in one face, whose edges are in line: no tangent plane
    };
    for (const Case& c :
         {Case{"catmull-clark", k_lid, 4, 0.05}, Case{"loop", k_lid, 4, 0.05}, Case{"tuned-loop", k_lid, 4, 0.05},
          Case{"modified-butterfly", k_lid, 4, 0.1}, Case{"doo-sabin", k_lid, 4, 4},
          Case{"kobbelt", k_flat_lid, 1, 0.1, 4}, Case{"4-8", k_flat_lid, 1, 0.1, 4}}) {
        CAPTURE(std::string(c.scheme));
        const std::string cube(k_cube);
        const ControlMesh whole = mesh_for(c.scheme, cube + c.lid + k_cup + k_sharp_ring);
        const Tessellation result = tessellate(whole, {.scheme = c.scheme, .tolerance = 5e-3, .measure = false});
        const TriangleMesh& mesh = result.mesh;
        REQUIRE(mesh.triangle_normals.size() == mesh.triangles.size());
        const int levels = result.deepest_level + 2;
        const auto side = [&](const char* faces) {
            return test::limits_of(mesh_for(c.scheme, cube + faces + k_smooth_boundary), *find_scheme(c.scheme), levels,
                                   {.normals = true});
        };
        const PolygonMesh sides[2] = {side(c.lid), side(k_cup)};
        const PointMatch match[2] = {PointMatch(sides[0].positions), PointMatch(sides[1].positions)};
        // The lid's faces come first.
        const auto side_of = [&](std::size_t t) { return result.triangle_face[t] < c.lid_faces ? 0 : 1; };
        std::set<std::uint32_t> on[2], turned;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (const std::uint32_t v : mesh.triangles[t]) on[side_of(t)].insert(v);
        std::size_t off = 0;
        for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = mesh.triangles[t][k];
                if (!on[0].contains(v) || !on[1].contains(v)) continue;
                const PolygonMesh& limits = sides[side_of(t)];
                const std::uint32_t i = match[side_of(t)].nearest(mesh.positions[v]);
                off += glm::length(limits.positions[i] - mesh.positions[v]) > 1e-9;
                if (degrees_between(corner_normal(mesh, t, k), limits.normals[i]) > c.degrees) turned.insert(v);
            }
        CHECK(off == 0);
        CHECK(turned.size() <= c.at_ends);
        // One more normal for each vertex on the crease.
        std::vector<std::uint32_t> both;
        std::set_intersection(on[0].begin(), on[0].end(), on[1].begin(), on[1].end(), std::back_inserter(both));
        CHECK(both.size() >= 12);
        CHECK(split_vertices(mesh) >= both.size());
        if (c.at_ends == 0) CHECK(split_vertices(mesh) <= both.size() + both.size() / 8);
    }
}

TEST_CASE("a dart's end has one normal, smooth vertices keep theirs") {
    const std::string text = std::string(test::k_closed) + "t crease 2/1/0 0 1 10\n";
    for (const char* scheme : {"catmull-clark", "loop"}) {
        CAPTURE(std::string(scheme));
        const ControlMesh mesh = mesh_for(scheme, text);
        const Tessellation result =
            tessellate(mesh, {.scheme = scheme, .tolerance = 5e-3, .crease_degrees = 180, .measure = false});
        // The sharp edge alone is split, without its ends: 1, 3, 7, ... points where all of it has the same level.
        const std::size_t split = split_vertices(result.mesh);
        CHECK(split >= 3);
        CHECK(split < std::size_t{1} << (result.deepest_level + 1));
        CHECK(result.mesh.normals.size() == result.mesh.positions.size() + split);
        const Tessellation smooth =
            tessellate(mesh_for(scheme, test::k_closed),
                       {.scheme = scheme, .tolerance = 5e-3, .crease_degrees = 180, .measure = false});
        CHECK(smooth.mesh.triangle_normals.empty());
        CHECK(smooth.mesh.normals.size() == smooth.mesh.positions.size());
    }
}

TEST_CASE("no normal is farther off its triangle than the crease angle, on roundings tighter than the tolerance") {
    std::string text = std::string(k_cube) + k_lid + k_cup;
    for (const char* edge : {"0 1", "1 2", "2 3", "3 0", "0 4", "1 5", "2 6", "3 7"})
        text += std::string("t crease 2/1/0 ") + edge + " 5\n";
    const ControlMesh mesh = mesh_for("catmull-clark", text);
    for (const char* scheme : {"catmull-clark", "kobbelt", "sqrt3"}) {
        CAPTURE(std::string(scheme));
        const ControlMesh cage = mesh_for(scheme, text);
        TessellateOptions options{.scheme = scheme, .tolerance = 1e-2, .measure = false};
        options.crease_degrees = 180;
        const Tessellation one = tessellate(cage, options);
        CHECK(one.mesh.triangle_normals.empty());
        CHECK(most_degrees_off(one.mesh) > 32);
        for (const double degrees : {15.0, 30.0}) {
            options.crease_degrees = degrees;
            const Tessellation split = tessellate(cage, options);
            CHECK(split.mesh.positions == one.mesh.positions);
            CHECK(split.mesh.triangles == one.mesh.triangles);
            CHECK(most_degrees_off(split.mesh) < degrees + 1e-6);
            for (const Vec3d& n : split.mesh.normals) CHECK(glm::length(n) == doctest::Approx(1));
            // Where the vertex's normal agrees with all triangles around, it stays.
            std::vector<std::uint8_t> agrees(one.mesh.positions.size(), 1);
            for (std::size_t t = 0; t < one.mesh.triangles.size(); ++t)
                for (std::size_t k = 0; k < 3; ++k)
                    if (degrees_off(one.mesh, t, k) > degrees) agrees[one.mesh.triangles[t][k]] = 0;
            std::size_t changed = 0, kept = 0;
            for (std::size_t t = 0; t < one.mesh.triangles.size(); ++t)
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t v = one.mesh.triangles[t][k];
                    if (agrees[v] == 0) continue;
                    ++kept;
                    changed += corner_normal(split.mesh, t, k) != one.mesh.normals[v];
                }
            CHECK(kept > 0);
            CHECK(changed == 0);
        }
    }
}

TEST_CASE("[bad-input] crease angles that are none") {
    const ControlMesh mesh = mesh_for("catmull-clark", std::string(k_cube) + k_lid + k_cup);
    for (const double degrees : {-1.0, 181.0, std::nan("")}) {
        TessellateOptions options{.tolerance = 1e-2, .measure = false};
        options.crease_degrees = degrees;
        CHECK_THROWS_WITH_AS(tessellate(mesh, options), doctest::Contains("crease angle must be 0 to 180"), Error);
    }
}

TEST_SUITE_END();
