#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/mesh/fan_choice.hpp"
#include "../../hier/mesh/mesh_repair.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

using namespace tetrakis;
using namespace tetrakis::test;
using test::Random;

namespace {

Vec3d area_vector(const ControlMesh& mesh, FaceId f) {
    Vec3d area(0.0);
    const HalfedgeId first = mesh.face_halfedge(f);
    for (std::uint32_t i = 1; i + 1 < mesh.face_size(f); ++i)
        area +=
            0.5 *
            glm::cross(mesh.position(mesh.origin(HalfedgeId(first.value + i))) - mesh.position(mesh.origin(first)),
                       mesh.position(mesh.origin(HalfedgeId(first.value + i + 1))) - mesh.position(mesh.origin(first)));
    return area;
}

Vec3d total_area(const ControlMesh& mesh) {
    Vec3d area(0.0);
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) area += area_vector(mesh, FaceId(f));
    return area;
}

ControlMesh mesh_of(std::vector<Vec3d> positions, const std::vector<std::vector<std::uint32_t>>& faces) {
    return ControlMesh::build(test::mesh_data(std::move(positions), faces));
}

FanChoice choose_all(const ControlMesh& mesh) { return choose_fans(mesh, mesh.positions()); }

std::vector<std::array<std::uint8_t, 3>> fan(const FanChoice& fans, std::uint32_t f) {
    const auto span = fans.of(FaceId(f));
    return {span.begin(), span.end()};
}

std::vector<std::uint8_t> all_of(const ControlMesh& mesh, const FanChoice& fans) {
    std::vector<std::uint8_t> use;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) use.push_back(fans.has(FaceId(f)) ? 1 : 0);
    return use;
}

/// Unordered vertex pairs of the fan's inner edges.
std::vector<std::pair<std::uint32_t, std::uint32_t>> diagonals(const ControlMesh& mesh, const FanChoice& fans,
                                                               FaceId f) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> result;
    const std::uint32_t n = mesh.face_size(f), h = mesh.face_halfedge(f).value;
    for (const auto& t : fans.of(f))
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if ((a + 1) % n == b || (b + 1) % n == a || a > b) continue;
            result.emplace_back(mesh.origin(HalfedgeId(h + a)).value, mesh.origin(HalfedgeId(h + b)).value);
        }
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("corners keep the angles of their sectors when faces are cut") {
    // Two quads and a pentagon about vertex 0, which is a corner between two creases and the boundary.
    auto data = mesh_data(
        {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {-1, 3, 0}, {-2, 2, 0}, {-2, 0, 0}, {-2, -2, 0}, {0, -2, 0}},
        {{0, 1, 2, 3}, {0, 3, 4, 5, 6}, {0, 6, 7, 8}});
    data.creases = {{0, 3, 5.0f}};
    data.corner_angles = {{0, 0, 1.0}, {0, 2, 2.0}};
    const ControlMesh before = ControlMesh::build(data), after = triangulate(before);
    REQUIRE(after.has_corner_angles());
    for (std::uint32_t h = 0; h < after.halfedge_count(); ++h) {
        if (after.origin(HalfedgeId(h)) != VertexId(0)) {
            CHECK(after.corner_angle(HalfedgeId(h)) == 0);
            continue;
        }
        const double x = after.position(after.target(HalfedgeId(h))).x,
                     y = after.position(after.origin(after.prev(HalfedgeId(h)))).x;
        CHECK(after.corner_angle(HalfedgeId(h)) == (x + y > 0 ? 1.0 : 2.0));
    }
}

TEST_CASE("a quadrilateral is cut along its shorter diagonal, a concave one through its reflex corner") {
    const auto diagonal = [](std::vector<Vec3d> points) {
        const ControlMesh mesh = triangulate(ControlMesh::build(mesh_data(std::move(points), {{0, 1, 2, 3}})));
        REQUIRE(mesh.face_count() == 2);
        for (std::uint32_t e = 0; e < mesh.edge_count(); ++e)
            if (!mesh.is_boundary(EdgeId(e))) return mesh.origin(mesh.edge_halfedge(EdgeId(e))).value % 2;
        return 99u;
    };
    CHECK(diagonal({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 1, 0}}) == 1);
    CHECK(diagonal({{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {-1, 1, 0}}) == 0);
    // An arrow head: the shorter diagonal, from 1 to 3, lies outside.
    CHECK(diagonal({{0, 0, 0}, {-1, -1, 0}, {9, 0, 0}, {-1, 1, 0}}) == 0);
}

TEST_CASE("a diagonal repeats no edge, and where none is free the face gets a centre") {
    const std::vector<Vec3d> square = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}};
    // The other side already has the diagonal 0-2: only 1-3 is left.
    const ControlMesh fold = triangulate(ControlMesh::build(mesh_data(square, {{0, 1, 2, 3}, {0, 3, 2}, {0, 2, 1}})));
    CHECK(fold.face_count() == 4);
    CHECK(fold.vertex_count() == 4);
    // Two quads back to back: one takes the shorter diagonal, the other must take the longer one.
    const ControlMesh pillow = triangulate(ControlMesh::build(mesh_data(square, {{0, 1, 2, 3}, {3, 2, 1, 0}})));
    CHECK(pillow.face_count() == 4);
    CHECK(pillow.edge_count() == 6);
    // Five quads on the torus whose edges join all five vertices: no diagonal is free anywhere.
    std::mt19937_64 random(3);
    auto torus =
        mesh_data(random_points(5, random), {{0, 1, 3, 2}, {1, 2, 4, 3}, {2, 3, 0, 4}, {3, 4, 1, 0}, {4, 0, 2, 1}});
    torus.uvs = {{0, 0}, {4, 0}, {0, 8}};
    torus.face_uvs = std::vector<std::uint32_t>(20, 0);
    torus.face_uvs[1] = 1;
    torus.face_uvs[2] = 2;
    const ControlMesh mesh = triangulate(ControlMesh::build(torus));
    CHECK(mesh.vertex_count() == 10);
    CHECK(mesh.face_count() == 20);
    CHECK(mesh.edge_count() == 30);
    const Vec3d mean = 0.25 * (torus.positions[0] + torus.positions[1] + torus.positions[2] + torus.positions[3]);
    CHECK(glm::length(mesh.position(VertexId(5)) - mean) < 1e-15);
    CHECK(mesh.data().uvs[3] == Vec2d(1, 2));
    REQUIRE(mesh.warnings().size() == 2);
    CHECK(mesh.warnings()[0] == "cut 5 of 5 faces into triangles");
    CHECK(contains(mesh.warnings()[1], "5 of them got a new vertex"));
}

TEST_CASE("triangulation of random surfaces keeps the area vector, the tags and every attribute") {
    for (const std::uint64_t seed : seeds(3))
        for (int i = 0; i < 300; ++i) {
            CAPTURE(seed);
            CAPTURE(i);
            std::mt19937_64 random(seed * 1009 + static_cast<std::uint64_t>(i));
            ControlMeshData data;
            const auto vertices = 6 + static_cast<std::uint32_t>(random() % 12);
            data.positions = random_points(vertices, random);
            data.face_offsets = {0};
            for (int f = 0; f < 12; ++f) {
                const std::uint64_t size = 3 + random() % 6;
                for (std::uint64_t k = 0; k < size; ++k)
                    data.face_vertices.push_back(static_cast<std::uint32_t>(random() % vertices));
                data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
                data.face_group.push_back(static_cast<std::uint32_t>(f));
                data.groups.push_back(std::to_string(f));
                if (f % 3 == 0) data.holes.push_back(static_cast<std::uint32_t>(f));
            }
            data.face_uvs = data.face_vertices;
            for (const Vec3d& p : data.positions) data.uvs.emplace_back(p.x, p.y);
            repair(data);
            for (std::uint32_t h = 0; h + 1 < data.face_offsets[1]; ++h)
                data.creases.push_back({data.face_vertices[h], data.face_vertices[h + 1], 1.5f});
            const ControlMesh before = ControlMesh::build(data);
            const ControlMesh after = triangulate(before);
            REQUIRE(after.all_triangles());
            REQUIRE(glm::length(total_area(after) - total_area(before)) < 1e-12);
            // Euler characteristic and boundary are those of the polygons.
            const auto boundary = [](const ControlMesh& mesh) {
                std::uint32_t count = 0;
                for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) count += mesh.is_boundary(EdgeId(e));
                return count;
            };
            REQUIRE(boundary(after) == boundary(before));
            REQUIRE(std::int64_t{after.vertex_count()} - after.edge_count() + after.face_count() ==
                    std::int64_t{before.vertex_count()} - before.edge_count() + before.face_count());
            std::uint32_t creases = 0, creases_before = 0;
            for (std::uint32_t e = 0; e < after.edge_count(); ++e) creases += after.sharpness(EdgeId(e)) == 1.5f;
            for (std::uint32_t e = 0; e < before.edge_count(); ++e)
                creases_before += before.sharpness(EdgeId(e)) == 1.5f;
            REQUIRE(creases == creases_before);
            for (std::uint32_t v = 0; v < before.vertex_count(); ++v)
                REQUIRE(after.sharpness(VertexId(v)) == before.sharpness(VertexId(v)));
            for (std::uint32_t h = 0; h < after.halfedge_count(); ++h) {
                const Vec3d p = after.position(after.origin(HalfedgeId(h)));
                const Vec2d uv = after.data().uvs[after.uv_index(HalfedgeId(h))];
                REQUIRE(glm::length(uv - Vec2d(p.x, p.y)) < 1e-14);
            }
            for (std::uint32_t f = 0; f < after.face_count(); ++f)
                REQUIRE(after.is_hole(FaceId(f)) == (after.data().face_group[f] % 3 == 0));
        }
}

TEST_CASE("a mesh of triangles stays as it is") {
    const ControlMesh mesh = ControlMesh::build(mesh_data({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
    const ControlMesh same = triangulate(mesh);
    CHECK(same.data().face_vertices == mesh.data().face_vertices);
    CHECK(same.warnings().empty());
}

TEST_CASE("fans tile their face and turn the right way") {
    for (std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        Random random(seed);
        // Star-shaped polygons, mostly concave.
        for (std::uint32_t n = 3; n <= k_max_fan_corners; ++n) {
            CAPTURE(n);
            std::vector<Vec3d> positions;
            std::vector<std::uint32_t> face;
            for (std::uint32_t i = 0; i < n; ++i) {
                const double a = 2 * std::numbers::pi * i / n, r = random.uniform(0.6, 1.6);
                positions.emplace_back(r * std::cos(a), r * std::sin(a), 0);
                face.push_back(i);
            }
            const ControlMesh mesh = mesh_of(positions, {face});
            const FanChoice fans = choose_all(mesh);
            REQUIRE(fans.has(FaceId(0)));
            double polygon = 0, sum = 0;
            for (std::uint32_t i = 0; i < n; ++i) {
                const Vec3d &p = positions[i], &q = positions[(i + 1) % n];
                polygon += p.x * q.y - p.y * q.x;
            }
            REQUIRE(fan(fans, 0).size() == n - 2);
            for (const auto& [a, b, c] : fan(fans, 0)) {
                const double area = glm::cross(positions[b] - positions[a], positions[c] - positions[a]).z;
                CHECK(area > 0);
                sum += area;
            }
            CHECK(sum == doctest::Approx(polygon).epsilon(1e-12));
        }
    }
}

TEST_CASE("faces of more corners than fans may have keep their centres") {
    for (const std::uint32_t n : {k_max_fan_corners, k_max_fan_corners + 1}) {
        std::vector<Vec3d> positions;
        std::vector<std::vector<std::uint32_t>> face(1);
        for (std::uint32_t i = 0; i < n; ++i) {
            const double a = 2 * std::numbers::pi * i / n;
            positions.emplace_back(std::cos(a), std::sin(a), 0);
            face[0].push_back(i);
        }
        CHECK(choose_all(mesh_of(positions, face)).has(FaceId(0)) == (n == k_max_fan_corners));
    }
}

TEST_CASE("no diagonal repeats an edge or another face's diagonal") {
    // Two quadrilaterals back to back: all four vertices have valence 2.
    const std::vector<Vec3d> square{{0, 0, 0}, {1, 0, 0}, {1.1, 1, 0}, {0, 1, 0}};
    const ControlMesh pillow = mesh_of(square, {{0, 1, 2, 3}, {3, 2, 1, 0}});
    const FanChoice fans = choose_all(pillow);
    REQUIRE((fans.has(FaceId(0)) && fans.has(FaceId(1))));
    CHECK(diagonals(pillow, fans, FaceId(0))[0] != diagonals(pillow, fans, FaceId(1))[0]);
    BisectionForest forest(pillow);
    const auto topology = test::topology(forest.exported(fans, all_of(pillow, fans)).triangles);
    CHECK(topology.fault.empty());
    CHECK(topology.euler == 2);
    // Two triangles back to back: the second keeps its centre.
    const ControlMesh flat = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}});
    const FanChoice one = choose_all(flat);
    CHECK((one.has(FaceId(0)) && !one.has(FaceId(1))));
    // A tetrahedron's two faces merged to a quadrilateral: one of its diagonals is the opposite edge, and the shorter.
    const ControlMesh wedge =
        mesh_of({{0, 0, 0}, {5, 0, 0}, {0, 1, 1}, {5, 1, -1}}, {{0, 1, 2}, {1, 0, 3}, {0, 2, 1, 3}});
    const FanChoice free = choose_all(wedge);
    REQUIRE(free.has(FaceId(2)));
    CHECK(diagonals(wedge, free, FaceId(2)) == std::vector<std::pair<std::uint32_t, std::uint32_t>>{{2, 3}});
    CHECK(test::topology(BisectionForest(wedge).exported(free, all_of(wedge, free)).triangles).fault.empty());
}

TEST_SUITE_END();
