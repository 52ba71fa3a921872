#include "../../eval/terrain/height_grid.hpp"
#include "../../eval/terrain/terrain_mesh.hpp"
#include "../../hier/base/error.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/judged_terrain.hpp"
#include "../kit/surface_topology.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

using namespace tetrakis;
using namespace tetrakis::test;

namespace {

void check_terrain(const HeightGrid& grid, double max_error, std::array<std::uint32_t, 2> tiles = {1, 1}) {
    CAPTURE(grid.columns);
    CAPTURE(grid.rows);
    CAPTURE(max_error);
    CAPTURE(tiles);
    const Terrain terrain =
        terrain_mesh(grid, {.max_error = max_error, .tiles = tiles, .context = {.threads = 2, .progress = {}}});
    const Judged judged = judge(terrain.mesh, grid);
    float highest = 1;
    for (const float height : grid.heights) highest = std::max(highest, std::abs(height));
    const double rounding = 1e-13 * double{highest};
    CHECK(judged.largest_error <= max_error + rounding);
    CHECK(judged.largest_error == doctest::Approx(terrain.largest_error).epsilon(1e-9).scale(rounding));
    CHECK(judged.unseen == 0);
    CHECK(judged.turned == 0);
    CHECK(judged.area == doctest::Approx((grid.columns - 1.0) * (grid.rows - 1.0)).epsilon(1e-12));
    const SurfaceTopology disc = topology(terrain.mesh.triangles);
    CHECK(disc.fault == "");
    CHECK(disc.euler == 1);
    CHECK(disc.boundary_loops == 1);
    for (const Vec3d& p : terrain.mesh.positions) REQUIRE(p.z == double{static_cast<float>(p.z)});
    REQUIRE(terrain.first_triangle.size() == tiles[0] * tiles[1] + 1);
    CHECK(terrain.first_triangle.front() == 0);
    CHECK(terrain.first_triangle.back() == terrain.mesh.triangles.size());
    for (std::uint32_t t = 0; t < tiles[0] * tiles[1]; ++t) {
        const TriangleMesh tile = terrain_tile(terrain, t);
        const std::uint32_t c = t % tiles[0], r = t / tiles[0];
        const Box3d box = bounding_box(tile.positions);
        REQUIRE(box.lower.x == c * (grid.columns - 1) / tiles[0]);
        REQUIRE(box.upper.x == (c + 1) * (grid.columns - 1) / tiles[0]);
        REQUIRE(-box.upper.y == r * (grid.rows - 1) / tiles[1]);
        REQUIRE(-box.lower.y == (r + 1) * (grid.rows - 1) / tiles[1]);
    }
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("terrain: every sample is within the tolerance, whatever the grid's size") {
    const std::pair<std::uint32_t, std::uint32_t> sizes[] = {{2, 2},    {8, 2},    {2, 13},   {3, 3},
                                                             {2, 40},   {41, 2},   {33, 33},  {32, 32},
                                                             {100, 70}, {257, 65}, {60, 200}, {129, 130}};
    unsigned seed = 0;
    for (const auto& [columns, rows] : sizes)
        for (const double max_error : {0.0, 0.05, 1.0, 20.0}) check_terrain(rough(columns, rows, ++seed), max_error);
}

TEST_CASE("terrain: tiles of any number are one mesh without cracks, and none crosses its borders") {
    const HeightGrid grid = rough(100, 70, 3);
    for (const double max_error : {0.0, 1.0, 50.0}) {
        for (const std::array<std::uint32_t, 2> tiles : {std::array{2u, 1u}, {1u, 5u}, {7u, 3u}, {50u, 2u}, {99u, 69u}})
            check_terrain(grid, max_error, tiles);
        check_terrain(rough(2, 40, 4), max_error, {1, 39});
        check_terrain(rough(65, 8, 5), max_error, {3, 7});
    }
}

TEST_CASE("terrain: tiles have the normals of the whole, which are the slope's on a plane") {
    const HeightGrid plane = grid_of(33, 33, [](double c, double r) { return 2 * c - r; });
    for (const bool y_up : {false, true}) {
        const Terrain terrain = terrain_mesh(plane, {.max_error = 0, .y_up = y_up, .normals = true, .tiles = {4, 4}});
        const Vec3d up = glm::normalize(Vec3d(-2, -1, 1)), expected = y_up ? Vec3d(up.x, up.z, -up.y) : up;
        REQUIRE(terrain.mesh.normals.size() == terrain.mesh.positions.size());
        for (const Vec3d& normal : terrain.mesh.normals) REQUIRE(glm::length(normal - expected) < 1e-12);
        CHECK(terrain_tile(terrain, 5).normals.size() == terrain_tile(terrain, 5).positions.size());
    }
    CHECK(terrain_mesh(plane).mesh.normals.empty());
}

TEST_CASE("terrain: noise, a spike, a cliff") {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> any(-1000, 1000);
    check_terrain(grid_of(90, 61, [&](auto, auto) { return any(random); }), 100);
    check_terrain(grid_of(90, 61, [&](auto, auto) { return any(random); }), 0);
    check_terrain(grid_of(90, 61, [](auto c, auto r) { return c == 37 && r == 59 ? 8848 : 0; }), 5);
    check_terrain(grid_of(90, 61, [](auto c, auto r) { return 3 * c < 70 + r ? 1e6 : -1e6; }), 1e-3);
}

TEST_CASE("terrain: splits that force each other along a strip of many squares") {
    // Only a spike at one end is too far at first; each split puts a corner on noise, so that the next square is split.
    std::mt19937 random(1);
    const HeightGrid strip = grid_of(4097, 17, [&](std::uint32_t c, std::uint32_t r) {
        if (c == 2 && r == 3) return 5.0;
        if (c % 16 == r % 16 && c % 8 == 0) return 0.0;
        return random() % 2 == 0 ? 0.9 : -0.9;
    });
    const Terrain terrain = terrain_mesh(strip, {.max_error = 1});
    CHECK(terrain.largest_error <= 1 + 1e-12);
    CHECK(terrain.mesh.triangles.size() > 10'000);
}

TEST_CASE("terrain: a plane takes the coarsest mesh, and heights of all signs are alike") {
    const HeightGrid plane = grid_of(65, 65, [](double c, double r) { return 2 * c - r; });
    CHECK(terrain_mesh(plane, {.max_error = 0}).mesh.triangles.size() == 4);
    const HeightGrid up = rough(80, 80, 5);
    HeightGrid down = up;
    for (float& height : down.heights) height = -height;
    CHECK(terrain_mesh(up, {.max_error = 2}).mesh.triangles == terrain_mesh(down, {.max_error = 2}).mesh.triangles);
}

TEST_CASE("terrain: heights move, so that half of the triangles do") {
    // Triangles through samples of this paraboloid have an error of 1 with legs of 16 (512 triangles), and of 1/2 after
    // the next bisection.
    const HeightGrid grid = grid_of(257, 257, [](double c, double r) { return (c * c + r * r) / 128; });
    CHECK(terrain_mesh(grid, {.max_error = 0.6}).mesh.triangles.size() < 600);
    CHECK(terrain_mesh(grid, {.max_error = 1}).mesh.triangles.size() <= 512);
}

TEST_CASE("terrain: Mount Fuji in fewer triangles than martini takes at the same error") {
    const char* const shared = std::getenv("TETRAKIS_SHARED_DIR");
    const std::filesystem::path path =
        std::filesystem::path(shared != nullptr ? shared : "") / "data/terrain/fuji-terrain-rgb.png";
    if (!std::filesystem::exists(path)) {
        MESSAGE("SKIPPED: there is no ", path.string(), " (set TETRAKIS_SHARED_DIR)");
        return;
    }
    const HeightGrid grid = load_height_grid(path);
    CHECK(grid.columns == 512);
    CHECK(grid.rows == 512);
    // Number of Martini's triangles at equal measured error (2026-11-21), and the part of it that must suffice here.
    for (const auto& [max_error, martini, share] :
         {std::tuple{1.0, 440583, 0.88}, {5.0, 265049, 0.51}, {10.0, 181578, 0.33}, {30.0, 45698, 0.29}}) {
        const Terrain terrain = terrain_mesh(grid, {.max_error = max_error});
        CHECK(static_cast<double>(terrain.mesh.triangles.size()) < share * martini);
        const Judged judged = judge(terrain.mesh, grid);
        CHECK(judged.largest_error <= max_error);
        CHECK(judged.unseen == 0);
    }
}

TEST_CASE("[invariant-10] terrain: the same mesh for any number of threads") {
    const HeightGrid grid = rough(400, 300, 11);
    const Terrain one = terrain_mesh(grid, {.max_error = 0.5, .context = {.threads = 1, .progress = {}}});
    CHECK(one.mesh.triangles.size() > 40000);
    for (const int threads : {2, 3, 4}) {
        const Terrain more = terrain_mesh(grid, {.max_error = 0.5, .context = {.threads = threads, .progress = {}}});
        CHECK(more.mesh.triangles == one.mesh.triangles);
        CHECK(more.mesh.positions == one.mesh.positions);
        CHECK(more.largest_error == one.largest_error);
    }
}

TEST_CASE("terrain: places on the ground, and engines' axes") {
    HeightGrid grid = rough(20, 30, 2);
    grid.spacing = {30, 25};
    grid.origin = {1000, 2000};
    const Terrain z_up = terrain_mesh(grid, {.max_error = 1}),
                  y_up = terrain_mesh(grid, {.max_error = 1, .y_up = true});
    CHECK(judge(z_up.mesh, grid).largest_error <= 1 + 1e-12);
    REQUIRE(y_up.mesh.triangles == z_up.mesh.triangles);
    Box3d box;
    for (std::size_t i = 0; i < z_up.mesh.positions.size(); ++i) {
        const Vec3d &z = z_up.mesh.positions[i], &y = y_up.mesh.positions[i];
        box.add(z);
        CHECK(y == Vec3d(z.x, z.z, -z.y));
    }
    CHECK(box.lower.x == 1000);
    CHECK(box.upper.x == 1000 + 19 * 30);
    CHECK(box.upper.y == 2000);
    CHECK(box.lower.y == 2000 - 29 * 25);
}

TEST_CASE("terrain: progress is told, and a run can be cancelled") {
    const HeightGrid grid = rough(100, 100, 1);
    double last = 0;
    TerrainOptions options{.max_error = 1};
    options.context.progress = [&](std::string_view, double fraction) {
        CHECK(fraction >= last);
        last = fraction;
        return true;
    };
    terrain_mesh(grid, options);
    CHECK(last == 1);
    options.context.progress = [](std::string_view, double fraction) { return fraction < 0.5; };
    CHECK_THROWS_AS(terrain_mesh(grid, options), Error);
}

TEST_CASE("terrain: more triangles than the memory limit lets be are an error") {
    TerrainOptions options{.max_error = 0};
    options.context.max_memory_bytes = 1 << 20;
    const Error error = error_of([&] { terrain_mesh(rough(200, 200, 4), options); });
    CHECK(error.code() == ErrorCode::memory_limit);
    CHECK(contains(error.what(), "use a larger error"));
}

TEST_CASE("[bad-input] terrain: grids and tolerances that are none") {
    const HeightGrid good = rough(5, 4, 1);
    const auto fault = [](const HeightGrid& grid, double max_error) -> std::string {
        const Error error = error_of([&] { terrain_mesh(grid, {.max_error = max_error}); });
        CHECK(error.code() == ErrorCode::invalid_input);
        return error.what();
    };
    CHECK_NOTHROW(terrain_mesh(good));
    CHECK(fault(HeightGrid{}, 1).find("0 columns and 0 rows") != std::string::npos);
    CHECK(fault(grid_of(1, 9, [](auto, auto) { return 0; }), 1).find("1 columns and 9 rows") != std::string::npos);
    HeightGrid bad = good;
    bad.heights.pop_back();
    CHECK(fault(bad, 1).find("19 heights") != std::string::npos);
    for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        bad = good;
        bad.heights[7] = value;
        CHECK(fault(bad, 1).find("column 2, row 1") != std::string::npos);
    }
    for (const double spacing : {0.0, -1.0, 1e-160, std::nan("")}) {
        bad = good;
        bad.spacing.y = spacing;
        CHECK(fault(bad, 1).find("spacing") != std::string::npos);
    }
    bad = good;
    bad.origin.y = std::nan("");
    CHECK(fault(bad, 1).find("reaches to") != std::string::npos);
    for (const std::array<std::uint32_t, 2> tiles : {std::array{0u, 1u}, {1u, 0u}, {5u, 1u}, {1u, 4u}})
        CHECK_THROWS_WITH_AS(terrain_mesh(good, {.tiles = tiles}), doctest::Contains("can have 1 x 1 to 4 x 3"), Error);
    for (const double max_error : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()})
        CHECK(fault(good, max_error).find("largest error") != std::string::npos);
}

TEST_SUITE_END();
