#include "../../hier/mesh/fan_choice.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::Random;

namespace {

ControlMesh mesh_of(std::vector<Vec3d> positions, const std::vector<std::vector<std::uint32_t>>& faces) {
    return ControlMesh::build(test::mesh_data(std::move(positions), faces));
}

FanChoice choose_all(const ControlMesh& mesh) {
    return choose_fans(mesh, mesh.positions(), std::vector<std::uint8_t>(mesh.face_count(), 1));
}

std::vector<std::array<std::uint8_t, 3>> fan(const FanChoice& fans, std::uint32_t f) {
    const auto span = fans.of(FaceId(f));
    return {span.begin(), span.end()};
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

TEST_CASE("a short diagonal that leaves another corner outside is not taken") {
    // A narrow V: the shorter diagonal is the one between its upper ends.
    const ControlMesh mesh = mesh_of({{0, 0, 0}, {0.5, -10, 0}, {1, 0, 0}, {0.5, -5, 0}}, {{0, 1, 2, 3}});
    CHECK(diagonals(mesh, choose_all(mesh), FaceId(0)) == std::vector<std::pair<std::uint32_t, std::uint32_t>>{{1, 3}});
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
    const auto topology = test::topology(forest.exported(fans, fans.accepted).triangles);
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
    CHECK(test::topology(BisectionForest(wedge).exported(free, free.accepted).triangles).fault.empty());
}

TEST_SUITE_END();
