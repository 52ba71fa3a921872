#include "../../eval/distance/hausdorff.hpp"

#include "../../eval/distance/mesh_sampling.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/meshes.hpp"
#include "../kit/nearest.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <random>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

TEST_CASE("closest points on triangles are those of the judges' own search, slivers and degenerate ones included") {
    std::mt19937_64 random(20240118);
    std::uniform_real_distribution<double> unit(0, 1);
    for (const double size : {1.0, 1e-20, 1e20})
        for (const double offset : {0.0, 1000.0}) {
            CAPTURE(size);
            CAPTURE(offset);
            TriangleMesh mesh;
            for (int i = 0; i < 150; ++i) {
                const Vec3d a = Vec3d(offset) + Vec3d(unit(random), unit(random), unit(random));
                const double side = std::pow(10.0, -4 * unit(random));
                const Vec3d ab = side * Vec3d(unit(random), unit(random), unit(random));
                Vec3d ac = side * Vec3d(unit(random), unit(random), unit(random));
                if (i % 5 == 1) ac = 0.3 * ab + 1e-7 * ac;  // a sliver
                if (i % 5 == 2) ac = 0.7 * ab;              // a segment
                if (i % 25 == 3) ac = Vec3d(0);             // two corners in one place
                for (const Vec3d& p : {a, a + ab, a + ac}) mesh.positions.push_back(size * p);
                const auto v = static_cast<std::uint32_t>(3 * i);
                mesh.triangles.push_back({v, v + 1, v + 2});
            }
            const TriangleBvh bvh(mesh);
            const test::NearestTriangle judge(mesh.positions, mesh.triangles);
            for (int i = 0; i < 500; ++i) {
                const Vec3d p = size * (Vec3d(offset) + 1.4 * Vec3d(unit(random), unit(random), unit(random)));
                const double best = judge.distance(p);
                const ClosestPoint found = bvh.closest(p);
                REQUIRE(found.found());
                // 1e-13 of the coordinates: what doubles that far from the origin can tell apart.
                REQUIRE(std::abs(found.distance - best) <= 1e-13 * size * (1 + offset));
                const auto& [a, b, c] = mesh.triangles[found.triangle];
                const Vec3d at = mesh.positions[a] + found.u * (mesh.positions[b] - mesh.positions[a]) +
                                 found.v * (mesh.positions[c] - mesh.positions[a]);
                REQUIRE(glm::length(at - found.point) <= 1e-14 * size * (1 + offset));
                REQUIRE(found.u >= 0);
                REQUIRE(found.v >= 0);
                REQUIRE(found.u + found.v <= 1 + 1e-12);
                REQUIRE(bvh.closest(p, found.distance).triangle == found.triangle);
                REQUIRE_FALSE(bvh.closest(p, found.distance * (1 - 1e-9)).found());
            }
        }
}

TEST_CASE("distances far below float resolution are exact") {
    const TriangleMesh sphere = shapes::sphere(40, 80, Vec3d(1e3, -2e3, 500), 1.0);
    const TriangleBvh bvh(sphere);
    for (const double lift : {1e-5, 1e-7, 1e-9})
        for (std::size_t t = 0; t < sphere.triangles.size(); t += 37) {
            const auto& [a, b, c] = sphere.triangles[t];
            const Vec3d &pa = sphere.positions[a], &pb = sphere.positions[b], &pc = sphere.positions[c];
            const Vec3d normal = glm::normalize(glm::cross(pb - pa, pc - pa));
            const ClosestPoint found = bvh.closest((pa + pb + pc) / 3.0 + lift * normal);
            REQUIRE(found.triangle == t);
            REQUIRE(std::abs(found.distance - lift) < 2e-12);  // coordinates of 2e3 resolve 2e-13
        }
}

TEST_CASE(
    "a triangle far away from all else neither changes the closest points nor makes each search look everywhere") {
    // To floats that reach the far triangle the whole sphere is in one place: 20'000 searches that look at all of its
    // 20'000 triangles take 30 times as long as this test.
    TriangleMesh mesh = shapes::sphere(100, 100, Vec3d(0.3, -0.2, 0.1), 1.0);
    const TriangleBvh alone(mesh);
    const TriangleMesh sphere = mesh;
    const std::uint32_t far = static_cast<std::uint32_t>(mesh.positions.size());
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    for (const Vec3d& p : {Vec3d(0, 0x1p32, 0), Vec3d(1, 0x1p32, 0), Vec3d(0, 0x1p32, 1)}) mesh.positions.push_back(p);
    mesh.triangles.push_back({far, far + 1, far + 2});
    const TriangleBvh bvh(mesh);
    std::mt19937_64 random(20240119);
    std::uniform_real_distribution<double> unit(-1.5, 1.5);
    std::vector<Vec3d> points(20'000);
    for (Vec3d& p : points) p = Vec3d(unit(random), unit(random), unit(random));
    for (std::size_t i = 0; i < 1000; ++i) points[i] = sphere.positions[i];  // ties
    std::vector<ClosestPoint> found(points.size()), expected(points.size());
    bvh.closest(points, found);
    alone.closest(points, expected);
    for (std::size_t i = 0; i < points.size(); ++i) {
        REQUIRE(found[i].triangle == expected[i].triangle);
        REQUIRE(found[i].distance == expected[i].distance);
        REQUIRE(found[i].point == expected[i].point);
    }
    CHECK(bvh.closest(Vec3d(0.1, 0x1.1p32, 0.1)).triangle == count);
    CHECK(bvh.closest(Vec3d(0, 0, 0x1p100)).distance == 0x1p100);  // too far for squares of floats
    CHECK(bvh.closest(points[7], found[7].distance).triangle == found[7].triangle);
    CHECK_FALSE(bvh.closest(Vec3d(0.3, -0.2, 0.1), 0.9).found());
}

TEST_CASE("vertices that no triangle uses do not matter, even where they are not finite") {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    for (int unused = 0; unused < 6; ++unused) {
        CAPTURE(unused);
        const TriangleBvh bvh(mesh);
        CHECK(bvh.closest(Vec3d(0.2, 0.2, 0.5)).distance == doctest::Approx(0.5).epsilon(1e-12));
        CHECK(bvh.intersect(Vec3d(0.2, 0.2, 1), Vec3d(0, 0, -1), 0, 10).triangle == 0);
        for (const double odd : {std::nan(""), std::numeric_limits<double>::infinity(), 1e300}) {
            CHECK(!bvh.intersect(Vec3d(odd, 0.2, 1), Vec3d(0, 0, -1)).found());
            CHECK(!bvh.intersect(Vec3d(0.2, 0.2, 1), Vec3d(0, odd, -1)).found());
            CHECK(!bvh.occluded(Vec3d(0.2, odd, 1), Vec3d(0, 0, -1)));
        }
        mesh.positions.push_back(Vec3d(std::nan("")));
    }
}

TEST_CASE("[inv10] batches give what single queries give, in any number of threads") {
    const TriangleMesh sphere = shapes::sphere(30, 60, Vec3d(0), 2.0);
    const TriangleBvh bvh(sphere);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(-3, 3);
    std::vector<Vec3d> points(3000);
    for (Vec3d& p : points) p = Vec3d(unit(random), unit(random), unit(random));
    for (std::size_t i = 0; i < 500; ++i) points[i] = sphere.positions[i];  // on vertices: ties among their triangles
    std::vector<ClosestPoint> single(points.size()), batch(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) single[i] = bvh.closest(points[i]);
    for (const int threads : {1, 2, 3}) {
        const RunContext context = test::with_thread_count(threads);
        bvh.closest(points, batch, context);
        for (std::size_t i = 0; i < points.size(); ++i) {
            REQUIRE(batch[i].triangle == single[i].triangle);
            REQUIRE(batch[i].distance == single[i].distance);
        }
    }
    std::vector<ClosestPoint> few(3);
    CHECK_THROWS_AS(bvh.closest(points, few), Error);
}

TEST_CASE("rays hit where the plane of the triangle is, to double precision") {
    const TriangleMesh sphere = shapes::sphere(30, 60, Vec3d(100), 2.0);
    const TriangleBvh bvh(sphere);
    std::mt19937_64 random(4);
    std::uniform_real_distribution<double> unit(-1, 1);
    int hits = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vec3d from = Vec3d(100) + 5.0 * glm::normalize(Vec3d(unit(random), unit(random), unit(random)));
        const Vec3d towards = Vec3d(100) + 2.5 * Vec3d(unit(random), unit(random), unit(random)) - from;
        const RayHit hit = bvh.intersect(from, towards);
        CHECK(bvh.occluded(from, towards) == hit.found());
        if (!hit.found()) continue;
        ++hits;
        const auto& [a, b, c] = sphere.triangles[hit.triangle];
        const Vec3d &pa = sphere.positions[a], &pb = sphere.positions[b], &pc = sphere.positions[c];
        const Vec3d at = from + hit.t * towards;
        const Vec3d normal = glm::normalize(glm::cross(pb - pa, pc - pa));
        CHECK(std::abs(glm::dot(at - pa, normal)) < 1e-12);
        CHECK(glm::length(pa + hit.u * (pb - pa) + hit.v * (pc - pa) - at) < 1e-4);
        CHECK_FALSE(bvh.occluded(from, towards, 0, hit.t * (1 - 1e-4)));
    }
    CHECK(hits > 400);
}

TEST_CASE("the samples inside a triangle are one in each of its equal parts") {
    for (const std::uint32_t m : {1u, 2u, 5u, 64u}) {
        std::vector<int> hits(m * m);
        Vec2d last(0);
        for (std::uint32_t k = 0; k < m * m; ++k) {
            const Vec2d uv = detail::inside_sample(k, m);
            const double x = uv.x * m, y = uv.y * m;
            const auto column = static_cast<std::uint32_t>(x), row = static_cast<std::uint32_t>(y);
            const bool inverted = x - column + y - row > 1;
            REQUIRE(column + row + (inverted ? 1 : 0) < m);
            // Rows of 2 (m - row) - 1 parts; those before this row make m^2 - (m - row)^2.
            ++hits[m * m - (m - row) * (m - row) + 2 * column + (inverted ? 1 : 0)];
            if (k > 0) REQUIRE(glm::length(uv - last) < 2.3 / m);
            last = uv;
        }
        for (const int count : hits) REQUIRE(count == 1);
    }
    CHECK(detail::inside_sample(0, 1).x == doctest::Approx(1.0 / 3));
}

TEST_CASE("climbing from the worst samples finds the top of a narrow bump") {
    // One large triangle under a cone of height 0.1: only its tip is that far; coarse samples miss it.
    TriangleMesh flat, cone;
    flat.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    flat.triangles = {{0, 1, 2}};
    cone = flat;
    cone.positions.push_back({0.301, 0.287, 0.1});
    cone.triangles = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    SamplingOptions few;
    few.samples = 40;
    const TriangleBvh to_cone(cone);
    few.climbs = 0;
    const double sampled = directed_distance(flat, to_cone, few).max;
    few.climbs = 32;
    const double climbed = directed_distance(flat, to_cone, few).max;
    // The point of the triangle that is farthest from the cone has equal distances to its faces; a dense sampling of
    // the same triangle is the independent answer.
    few.samples = 1'000'000;
    few.climbs = 0;
    const double dense = directed_distance(flat, to_cone, few).max;
    CHECK(climbed > sampled);
    CHECK(climbed >= dense);
    CHECK(climbed <=
          dense + 1.5e-3);  // no point is farther than a part's diameter from a sample, and distance is 1-Lipschitz
}

TEST_CASE("[inv10] the thread count changes no byte of a comparison") {
    const TriangleMesh a = shapes::sphere(30, 60, Vec3d(0), 1.0), b = shapes::sphere(17, 31, Vec3d(0.01), 1.0);
    SamplingOptions options;
    options.samples = 30'000;
    options.per_triangle = true;
    MeshComparison reference;
    for (const int threads : {1, 2, 3}) {
        const MeshComparison result = compare(a, b, options, test::with_thread_count(threads));
        if (threads == 1) {
            reference = result;
            REQUIRE(result.backward.triangle_max.size() == b.triangles.size());
            const float top =
                *std::max_element(result.backward.triangle_max.begin(), result.backward.triangle_max.end());
            CHECK(top >= result.error.backward);
            CHECK(top <= result.error.backward * (1 + 1e-6));
            continue;
        }
        CHECK(std::memcmp(&result.error, &reference.error, sizeof(MeasuredError)) == 0);
        CHECK(result.forward.triangle_max == reference.forward.triangle_max);
        CHECK(result.backward.triangle_max == reference.backward.triangle_max);
        CHECK(result.forward.nearest_max == reference.forward.nearest_max);
        CHECK(result.backward.nearest_max == reference.backward.nearest_max);
        CHECK(result.forward.worst_triangle == reference.forward.worst_triangle);
    }
}

TEST_CASE(
    "distances count for the triangles that they are nearest to, whether triangles are sampled or vertices alone") {
    const TriangleMesh fine = shapes::sphere(60, 120, Vec3d(0), 1.0), coarse = shapes::sphere(12, 24, Vec3d(0), 1.0);
    const TriangleBvh to_coarse(coarse);
    SamplingOptions options{.samples = 1000, .climbs = 0, .per_triangle = true};
    const DirectedDistance whole = directed_distance(fine, to_coarse, options);
    options.vertices_alone = true;
    const DirectedDistance vertices = directed_distance(fine, to_coarse, options);
    CHECK(vertices.samples == fine.positions.size());
    CHECK(vertices.mean == doctest::Approx(whole.mean).epsilon(0.02));
    CHECK(vertices.rms == doctest::Approx(whole.rms).epsilon(0.02));
    CHECK(vertices.max <= whole.max);
    CHECK(vertices.max > 0.97 * whole.max);
    REQUIRE(vertices.nearest_max.size() == coarse.triangles.size());
    CHECK(*std::ranges::max_element(vertices.nearest_max) == *std::ranges::max_element(vertices.triangle_max));
    // Each triangle is nearest to the piece of the sphere above it.
    for (std::size_t t = 0; t < coarse.triangles.size(); ++t) {
        const auto& [a, b, c] = coarse.triangles[t];
        const Vec3d centre = (coarse.positions[a] + coarse.positions[b] + coarse.positions[c]) / 3.0;
        const double above = 1 - glm::length(centre);
        CHECK(whole.nearest_max[t] >= vertices.nearest_max[t]);
        CHECK(whole.nearest_max[t] > 0.9 * above);
        CHECK(whole.nearest_max[t] < 2 * above + 1e-3);
    }
}

TEST_CASE("a long thin triangle is sampled all along, and samples far beyond a triangle can be left out of its error") {
    // A square, and a strip beside it that the other mesh bends down near its end.
    TriangleMesh square;
    square.positions = {{0, -1, 0}, {1, -1, 0}, {1, 0, 0}, {0, 0, 0}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    TriangleMesh flat = square, bent = square, above;
    const auto add = [](TriangleMesh& mesh, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {a, b, c});
        mesh.triangles.push_back({first, first + 1, first + 2});
    };
    constexpr double k_width = 1e-4, k_deep = 0.01;
    add(flat, {0, 2, 0}, {1, 2, 0}, {0, 2 + k_width, 0});
    for (const double begin : {0.0, 0.1, 0.15, 0.2}) {
        const double end = begin == 0 ? 0.1 : begin == 0.2 ? 1 : begin + 0.05;
        const auto at = [&](double x, double y) { return Vec3d(x, 2 + y, std::abs(x - 0.15) < 0.01 ? -k_deep : 0); };
        add(bent, at(begin, 0), at(end, 0), at(begin, k_width));
        add(bent, at(end, 0), at(end, k_width), at(begin, k_width));
    }
    const TriangleBvh to_bent(bent);
    SamplingOptions options{.samples = 2000, .climbs = 0, .per_triangle = true};
    const DirectedDistance thin = directed_distance(flat, to_bent, options);
    CHECK(thin.triangle_max[2] > 0.4 * k_deep);
    CHECK(thin.samples < 2 * options.samples);

    // One vertex lies a little above the square, another far beyond its side.
    add(above, {0.9, -0.5, 0.1}, {0.8, -0.5, 0}, {9, -0.5, 0});
    const TriangleBvh to_square(square);
    options.vertices_alone = true;
    CHECK(directed_distance(above, to_square, options).nearest_max[0] == doctest::Approx(8));
    options.within_size = true;
    const DirectedDistance near = directed_distance(above, to_square, options);
    CHECK(near.nearest_max[0] == doctest::Approx(0.1));
    CHECK(near.max == doctest::Approx(8));
}

TEST_CASE("[bad-input] meshes that cannot be measured, and a comparison that is cancelled") {
    const TriangleMesh good = shapes::octahedron();
    TriangleMesh empty = good, dangling = good, broken = good;
    empty.triangles.clear();
    dangling.triangles[3][1] = 99;
    broken.positions[2].y = std::nan("");
    CHECK_THROWS_WITH_AS(compare(empty, good), "the reference mesh has no triangles", Error);
    CHECK_THROWS_WITH_AS(compare(good, empty), "the mesh has no triangles", Error);
    CHECK_THROWS_WITH_AS(compare(good, dangling), "triangle 3 uses vertex 99, but there are 6 vertices", Error);
    CHECK_THROWS_WITH_AS(compare(broken, good), "vertex 2 is not finite or beyond 1e+60; scale the mesh down", Error);
    TriangleMesh far = good;
    far.positions[2].y = 1e300;
    CHECK_THROWS_WITH_AS(compare(good, far), "vertex 2 is not finite or beyond 1e+60; scale the mesh down", Error);
    CHECK_THROWS_AS(TriangleBvh{dangling}, Error);
    CHECK_THROWS_AS(TriangleBvh{broken}, Error);
    RunContext context;
    context.progress = [](std::string_view, double) { return false; };
    CHECK(test::error_of([&] { compare(good, good, {}, context); }).code() == ErrorCode::cancelled);
}

TEST_SUITE_END();
