#include "../../eval/tessellate/tessellate.hpp"
#include "../../eval/triangles/face_distance.hpp"
#include "../../eval/triangles/mesh_sliding.hpp"
#include "../../eval/triangles/point_triangle.hpp"

#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

using namespace tetrakis;
using detail::FaceDistance;

namespace {

using Corners = std::array<Vec3d, 3>;

Vec3d random_vector(test::Random& random) {
    return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

/// A triangle with angles of at least 20 degrees.
Corners random_triangle(test::Random& random) {
    for (;;) {
        const Corners c{random_vector(random), random_vector(random), random_vector(random)};
        const double area = glm::length(glm::cross(c[1] - c[0], c[2] - c[0]));
        double longest = 0;
        for (std::size_t k = 0; k < 3; ++k) longest = std::max(longest, glm::length(c[(k + 1) % 3] - c[k]));
        if (area > 0.4 * longest * longest) return c;
    }
}

/// The flap over edge k, beyond the triangle, turned by `fold` against its plane.
Corners flap(const Corners& c, std::size_t k, double tangent, double fold) {
    const Vec3d a = c[k], b = c[(k + 1) % 3], apex = c[(k + 2) % 3];
    const Vec3d along = glm::normalize(b - a), normal = glm::normalize(glm::cross(b - a, apex - a));
    const Vec3d out = glm::cross(along, normal);
    const double half = 0.5 * glm::length(b - a);
    return {b, a, a + half * along + half * tangent * (std::cos(fold) * out + std::sin(fold) * normal)};
}

double distance_to(const Vec3d& p, const Corners& c) {
    return std::sqrt(detail::nearest_on_triangle(p, c[0], c[1], c[2]).squared_distance);
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("distances of many points to a triangle are those of each point") {
    test::Random random(5);
    for (int i = 0; i < 1000; ++i) {
        const Corners c = random_triangle(random);
        const FaceDistance face(c);
        REQUIRE(face.has_squares());
        std::array<std::array<double, FaceDistance::k_most_points>, 3> points{};
        for (int p = 0; p < static_cast<int>(FaceDistance::k_most_points); ++p) {
            // The first six lie at the corners and on the edges.
            const auto k = static_cast<std::size_t>(p % 3);
            const Vec3d at = p < 3 ? c[k] : p < 6 ? 0.5 * (c[k] + c[(k + 1) % 3]) : 2.0 * random_vector(random);
            for (int x = 0; x < 3; ++x) points[static_cast<std::size_t>(x)][static_cast<std::size_t>(p)] = at[x];
        }
        const std::size_t count = i % 2 == 0 ? 16 : 28;
        FaceDistance::Squares squares;
        face.squares({points[0].data(), points[1].data(), points[2].data()}, count, squares);
        for (std::size_t p = 0; p < count; ++p) {
            const Vec3d local = face.local({points[0][p], points[1][p], points[2][p]});
            CHECK(std::sqrt(squares[0][p]) == doctest::Approx(face.to_face(local)).epsilon(1e-14));
            for (std::size_t k = 0; k < 3; ++k)
                CHECK(std::sqrt(squares[k + 1][p]) == doctest::Approx(face.to_edge(local, k)).epsilon(1e-14));
        }
    }
    EdgeSliding sliding;
    sliding.edge[1] = true;
    CHECK_FALSE(FaceDistance({Vec3d(0), {1, 0, 0}, {0, 1, 0}}, sliding).has_squares());
    CHECK_FALSE(FaceDistance({Vec3d(0), {1, 0, 0}, {2, 1e-3, 0}}).has_squares());
}

TEST_CASE("[inv9] with sliding, errors bound the distance from a triangle and its neighbours") {
    test::Random random(1);
    for (int i = 0; i < 400; ++i) {
        const Corners c = random_triangle(random);
        EdgeSliding edges;
        std::vector<Corners> mesh{c};
        for (std::size_t k = 0; k < 3; ++k) {
            if (random.chance(0.3)) continue;
            edges.edge[k] = true;
            edges.fold[k] = random.uniform(0, k_largest_fold);
            edges.flap[k] = random.uniform(0.05, 0.17);
            mesh.push_back(flap(c, k, edges.flap[k], random.uniform(-edges.fold[k], edges.fold[k])));
        }
        const FaceDistance sliding(c, edges), still(c);
        const double size = glm::length(c[1] - c[0]);
        for (int j = 0; j < 200; ++j) {
            // Mostly near an edge, beyond it or not.
            const std::size_t k = random.below(3);
            const double along = random.uniform(-0.05, 1.05);
            const Vec3d on_edge = c[k] + along * (c[(k + 1) % 3] - c[k]);
            const double reach = std::pow(10.0, random.uniform(-4, -0.5)) * size;
            const Vec3d p = on_edge + reach * random_vector(random);
            const Vec3d local = sliding.local(p);
            double nearest = 1e300, nearest_of_edge = 1e300;
            for (const Corners& t : mesh) nearest = std::min(nearest, distance_to(p, t));
            const double rounding = 1e-12;
            CHECK(sliding.stretch() * sliding.to_face(local) >= nearest - rounding);
            CHECK(sliding.to_face(local) <= still.to_face(local) + rounding);
            if (sliding.slides(k)) {
                nearest_of_edge = std::min(distance_to(p, c), distance_to(p, flap(c, k, edges.flap[k], 0)));
                CHECK(sliding.stretch() * sliding.to_edge(local, k) >= nearest_of_edge - rounding);
                CHECK(sliding.to_edge(local, k) <= still.to_edge(local, k) + rounding);
                // What is no error for the side is none for the leaf.
                CHECK(sliding.to_face(local) <= sliding.to_edge(local, k) + rounding);
            }
        }
    }
}

TEST_CASE("[inv9] at the ends of a line errors with sliding bound those on it, and change no faster than points move") {
    test::Random random(2);
    for (int i = 0; i < 300; ++i) {
        const Corners c = random_triangle(random);
        EdgeSliding edges;
        const double fold = random.uniform(0.01, k_largest_fold);
        for (std::size_t k = 0; k < 3; ++k) edges.edge[k] = true, edges.fold[k] = fold, edges.flap[k] = 0.17;
        const FaceDistance sliding(c, edges);
        std::vector<Corners> mesh{c};
        for (std::size_t k = 0; k < 3; ++k) mesh.push_back(flap(c, k, 0.17, random.chance(0.5) ? fold : -fold));
        for (int j = 0; j < 100; ++j) {
            const std::size_t k = random.below(3);
            const double reach = std::pow(10.0, random.uniform(-3, -0.5));
            const auto near_edge = [&] {
                return c[k] + random.uniform(0, 1) * (c[(k + 1) % 3] - c[k]) + reach * random_vector(random);
            };
            const Vec3d a = near_edge(), b = near_edge();
            const double ends = std::max(sliding.to_face(sliding.local(a)), sliding.to_face(sliding.local(b)));
            const double own = random.uniform(0, 0.5 * reach), t = random.uniform();
            const Vec3d away = random_vector(random);
            const Vec3d p = (1 - t) * a + t * b + own / glm::length(away) * away;
            double nearest = 1e300;
            for (const Corners& m : mesh) nearest = std::min(nearest, distance_to(p, m));
            CHECK(nearest <= sliding.stretch() * (ends + own) + 1e-12);
        }
    }
}

TEST_CASE("folds and flaps of a mesh") {
    // Two right-angled triangles over the unit square's diagonal, the second turned about it.
    for (const double turn : {0.0, 0.1, 0.2, 0.3, 2.0}) {
        CAPTURE(turn);
        const Vec3d axis = glm::normalize(Vec3d(1, 1, 0)), out = glm::normalize(Vec3d(-1, 1, 0));
        const std::vector<Vec3d> positions{
            {0, 0, 0},
            {1, 0, 0},
            {1, 1, 0},
            0.5 * Vec3d(1, 1, 0) + std::sqrt(0.5) * (std::cos(turn) * out + std::sin(turn) * glm::cross(axis, out))};
        const std::vector<std::array<std::uint32_t, 3>> triangles{{0, 1, 2}, {2, 3, 0}};
        const MeshSliding mesh(triangles, positions);
        const EdgeSliding own = mesh.of(0, {true, true, true});
        CHECK(!own.edge[0]);
        CHECK(!own.edge[1]);
        CHECK(own.edge[2] == (std::tan(turn) <= k_largest_fold && turn < 1));
        if (own.edge[2]) {
            CHECK(own.fold[2] >= turn);
            CHECK(own.fold[2] <= std::tan(turn) + 1e-5);
            CHECK(own.flap[2] == doctest::Approx(std::tan(0.125 * 3.14159265358979)).epsilon(1e-5));
            CHECK(own.flap[2] <= std::tan(0.125 * 3.14159265358979));
        }
        CHECK(!mesh.of(0, {true, true, false}).any());
    }
}

TEST_CASE("[inv9] certified errors of meshes that the measured estimator made know of their neighbours") {
    // A flat disc of n-gons with a round rim: inside there is nothing but sliding.
    constexpr std::uint32_t n = 6;
    std::vector<Vec3d> positions;
    std::vector<std::vector<std::uint32_t>> faces(1);
    for (std::uint32_t ring = 1; ring <= 3; ++ring)
        for (std::uint32_t i = 0; i < n; ++i) {
            const double angle = 2 * 3.14159265358979 * (i + 0.3 * ring) / n;
            positions.push_back({ring * std::cos(angle), ring * ring * 0.4 * std::sin(angle), 0});
        }
    for (std::uint32_t i = 0; i < n; ++i) {
        faces[0].push_back(i);
        for (const std::uint32_t ring : {0u, n}) {
            const std::uint32_t a = ring + i, b = ring + (i + 1) % n;
            faces.push_back({a, a + n, b + n, b});
        }
    }
    const ControlMesh mesh = ControlMesh::build(test::mesh_data(std::move(positions), faces));
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 1e-3;
    options.min_level = 2;
    const Tessellation result = tessellate(mesh, options);
    CHECK(result.measured_error->hausdorff <= result.tolerance_absolute);
    CHECK(*result.certified_error <= 1.1 * result.tolerance_absolute);
}

TEST_SUITE_END();
