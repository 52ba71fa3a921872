#include "../../eval/distance/limit_closest.hpp"
#include "../../eval/distance/nearest_in_root.hpp"

#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

namespace {

/// Two apices over a ring of n vertices; the faces around the first are halved by a second ring, so that some are
/// quads.
ControlMesh bipyramid(std::uint32_t n, bool quads) {
    std::vector<Vec3d> positions{{0, 0, 1}, {0, 0, -1}};
    std::vector<std::vector<std::uint32_t>> faces;
    for (std::uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    for (std::uint32_t i = 0; quads && i < n; ++i) positions.push_back(0.5 * (positions[2 + i] + positions[0]));
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % n;
        faces.push_back({1, b, a});
        faces.push_back(quads ? std::vector{0u, a + n, b + n} : std::vector{0u, a, b});
        if (quads) faces.push_back({a, b, b + n, a + n});
    }
    return ControlMesh::build(test::mesh_data(std::move(positions), faces));
}

/// Points beside the surface within the first faces, down to the first apex; the search against that of every root.
template <class Closest, class Patches, class Frame>
void check_search(const ControlMesh& mesh, detail::RootShape shape, Frame&& frame, std::uint64_t seed) {
    const Patches patches(mesh);
    const Closest closest(patches);
    closest.prepare({});
    test::Random random(seed);
    const bool square = shape == detail::RootShape::square;
    for (int i = 0; i < 12; ++i) {
        const HalfedgeId leaving = mesh.vertex_halfedge(VertexId(0));
        const double near = std::pow(10.0, random.uniform(-3, 0));
        double x = 0.45 * near, y = 0.45 * near * random.uniform(0, 1);
        HalfedgeId root = leaving;
        if (!square) {
            root = mesh.face_halfedge(mesh.face(leaving));
            std::array<double, 3> b{};
            const std::uint32_t k = leaving.value - root.value;
            b[k] = 1 - x - y, b[(k + 1) % 3] = x, b[(k + 2) % 3] = y;
            x = b[1], y = b[2];
        }
        const SurfacePoint s = frame(patches, root, x, y);
        const Vec3d q = s.position + near * random.uniform(-0.1, 0.1) * Vec3d(0.1, 0.2, 1);
        const double start = glm::length(q - s.position);
        double expected = start;
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); h += square ? 1 : 3)
            expected = std::min(
                expected, detail::nearest_in_root(
                              shape, false, q, [&](double u, double v) { return frame(patches, HalfedgeId(h), u, v); },
                              [&](double u, double v) { return frame(patches, HalfedgeId(h), u, v).position; }));
        CHECK(std::abs(closest.global(q, start) - expected) <= 1e-14);
    }
}

}  // namespace

TEST_CASE("[slow] beside a vertex of many edges the closest point is that of a search of every root") {
    for (const std::uint32_t n : {24u, 70u}) {
        CAPTURE(n);
        for (const bool quads : {false, true})
            check_search<QuadClosest, QuadPatches>(
                bipyramid(n, quads), detail::RootShape::square,
                [](const QuadPatches& p, HalfedgeId root, double x, double y) { return p.frame(root, x, y); }, n);
        check_search<LoopClosest, LoopPatches>(
            bipyramid(n, false), detail::RootShape::triangle,
            [](const LoopPatches& p, HalfedgeId root, double x, double y) { return p.frame(root, x, y); }, n);
    }
}

TEST_CASE("a hull is beyond a reach only if all of it is") {
    test::Random random(5);
    int beyond = 0;
    for (int i = 0; i < 2000; ++i) {
        std::array<Vec3d, 8> points;
        for (Vec3d& p : points) p = Vec3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.1, 0.1));
        const Vec3d q(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-1, 1));
        const double reach = random.uniform(0, 1);
        const auto at = [&](int k) { return points[static_cast<std::size_t>(k)]; };
        if (!detail::hull_beyond(8, at, q, reach)) continue;
        ++beyond;
        for (int j = 0; j < 50; ++j) {
            Vec3d inside(0);
            double sum = 0;
            for (const Vec3d& p : points) {
                const double w = std::pow(random.uniform(0, 1), 4);
                inside += w * p, sum += w;
            }
            REQUIRE(glm::length(q - inside / sum) >= reach * (1 - 1e-12));
        }
    }
    CHECK(beyond > 500);
}

TEST_SUITE_END();
