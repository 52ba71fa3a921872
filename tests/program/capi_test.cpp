#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/planet_surface.hpp"
#include "../../eval/lod_surfaces/procedural_surface.hpp"
#include "../../eval/lod_surfaces/subdivision_surface.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../tools/capi/tetrakis_c.h"

#include "../kit/cli.hpp"
#include "../kit/judged_terrain.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

using namespace tetrakis;
using namespace tetrakis::test;

namespace {

bool last_error_says(const std::string& words) {
    return std::string(tetrakis_last_error()).find(words) != std::string::npos;
}

/// Whether the C API's numbers or records are the C++ ones, byte for byte.
bool same_bytes(const void* numbers, std::uint32_t count, const auto& expected) {
    return count == expected.size() && std::memcmp(numbers, expected.data(), count * sizeof(expected[0])) == 0;
}

/// A walk around both is the same, byte for byte, and rays from above meet both at the same places. Frees the C
/// surface.
void check_same(const lod::Surface& surface, tetrakis_surface* c_surface, double size, const Vec3d& middle = Vec3d(0)) {
    lod::View view(surface, {.max_leaves = 5000});
    tetrakis_view* c_view = nullptr;
    tetrakis_view_options options = TETRAKIS_VIEW_OPTIONS;
    options.max_leaves = 5000;
    REQUIRE(tetrakis_make_view(c_surface, &options, &c_view) == TETRAKIS_OK);
    tetrakis_update c_update = TETRAKIS_UPDATE;
    std::uint32_t count = 0, capacity = 0, merges = 0, unfinished = 0;
    for (int frame = 0; frame < 60; ++frame) {
        CAPTURE(frame);
        const Vec3d out(std::cos(0.1 * frame), std::sin(0.1 * frame), 0.5);
        lod::Camera camera{
            .eye = middle + size * (1 + 0.4 * std::sin(frame)) * out, .direction = -out, .up = {0, 1, 9}};
        camera.vertical_fov = frame < 30 ? 1 : 1.2;
        camera.width = 1000, camera.height = 700;
        // A millionth of a millisecond is always over when time is looked at first.
        const lod::Budget budget{.pixel_error = frame % 9 < 6 ? 2.0 : 3.0,
                                 .leaves = frame % 7 < 5 ? 4000u : 400u,
                                 .milliseconds = frame % 8 < 6 ? 0 : 1e-6};
        tetrakis_camera c_camera = TETRAKIS_CAMERA;
        for (int k = 0; k < 3; ++k) {
            c_camera.eye[k] = camera.eye[k];
            c_camera.direction[k] = camera.direction[k];
            c_camera.up[k] = camera.up[k];
        }
        c_camera.vertical_fov = camera.vertical_fov;
        c_camera.width = 1000, c_camera.height = 700;
        const tetrakis_budget c_budget{sizeof c_budget, budget.pixel_error, budget.leaves, budget.milliseconds};
        if (frame % 20 == 10) {
            const Vec3d& eye = camera.eye;
            view.set_origin(eye);
            view.set_regions({{.center = middle, .radius = size / 9, .boost = 3}});
            const tetrakis_region region{{middle.x, middle.y, middle.z}, size / 9, 3};
            REQUIRE(tetrakis_set_view_origin(c_view, &eye.x) == TETRAKIS_OK);
            REQUIRE(tetrakis_set_view_regions(c_view, &region, 1) == TETRAKIS_OK);
        }
        const lod::Update update = view.update(camera, budget);
        REQUIRE(tetrakis_update_view(c_view, &c_camera, &c_budget, &c_update) == TETRAKIS_OK);
        REQUIRE(c_update.leaves == update.leaves);
        REQUIRE(c_update.splits == update.splits);
        REQUIRE(c_update.merges == update.merges);
        REQUIRE(c_update.pixel_error == update.pixel_error);
        REQUIRE(c_update.morph_scale == update.morph_scale);
        REQUIRE(c_update.complete == int{update.complete});
        REQUIRE(c_update.waiting == update.waiting);
        REQUIRE(same_bytes(c_update.vertex_ranges, c_update.vertex_range_count, update.vertices));
        REQUIRE(same_bytes(c_update.triangle_ranges, c_update.triangle_range_count, update.triangles));
        const tetrakis_vertex* vertices = tetrakis_view_vertices(c_view, &count, &capacity);
        REQUIRE(same_bytes(vertices, count, view.vertices()));
        REQUIRE(capacity == view.vertex_capacity());
        const std::uint32_t* triangles = tetrakis_view_triangles(c_view, &count, &capacity);
        REQUIRE(same_bytes(triangles, count, view.triangles()));
        REQUIRE(capacity == view.triangle_capacity());
        merges += update.merges;
        unfinished += !update.complete;
    }
    CHECK(merges > 100);
    CHECK(unfinished > 5);
    tetrakis_free_view(c_view);
    for (int i = 0; i < 100; ++i) {
        const Vec3d from = middle + size / 8 * Vec3d(std::sin(i), std::cos(2 * i), 8), along(0.003 * i, 0.1, -1);
        const auto expected = surface.hit(from, along);
        double t = 0;
        Vec3d normal(0);
        REQUIRE(tetrakis_surface_hit(c_surface, &from.x, &along.x, INFINITY, &t, &normal.x) == (expected ? 1 : 0));
        CHECK(t == (expected ? expected->t : 0));
        CHECK(normal == (expected ? expected->normal : Vec3d(0)));
        CHECK((expected || i > 50));
    }
    tetrakis_free_surface(c_surface);
}

}  // namespace

TEST_CASE("capi: a view is the C++ one's, byte for byte, of a terrain in memory and of one in tiles") {
    HeightGrid grid = rough(300, 280, 3);
    const ScratchDir scratch;
    const std::string heights = (scratch / "h.r32").string(), path = (scratch / "h.tiles").string();
    spill(heights, std::string(reinterpret_cast<const char*>(grid.heights.data()), 4 * grid.heights.size()));
    tetrakis_height_options reading = TETRAKIS_HEIGHT_OPTIONS;
    reading.columns = grid.columns;
    REQUIRE(tetrakis_write_tiles(heights.c_str(), &reading, path.c_str()) == TETRAKIS_OK);
    const lod::TiledTerrain tiles(path);
    tetrakis_surface *c_surface = nullptr, *c_tiles = nullptr;
    REQUIRE(tetrakis_open_tiles(path.c_str(), 1 << 26, &c_tiles) == TETRAKIS_OK);
    tetrakis_view* c_view = nullptr;
    REQUIRE(tetrakis_make_view(c_tiles, nullptr, &c_view) == TETRAKIS_OK);
    lod::View everything(tiles);
    while (everything.update({}, {.pixel_error = 1e-12}).waiting > 0) tiles.wait(tiles.revision());
    const tetrakis_camera c_camera = TETRAKIS_CAMERA;
    const tetrakis_budget c_budget{sizeof c_budget, 1e-12, UINT32_MAX, 0};
    for (tetrakis_update c_update = TETRAKIS_UPDATE; c_update.leaves == 0 || c_update.waiting > 0;) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        REQUIRE(tetrakis_update_view(c_view, &c_camera, &c_budget, &c_update) == TETRAKIS_OK);
    }
    tetrakis_free_view(c_view);
    check_same(tiles, c_tiles, 300, {150, -140, 0});

    grid.spacing = Vec2d(2);
    const lod::TerrainSurface surface(grid);
    const lod::ViewOptions known;
    const tetrakis_view_options options = TETRAKIS_VIEW_OPTIONS;
    CHECK(options.max_leaves == known.max_leaves);
    CHECK(options.max_bytes == known.max_bytes);
    CHECK(options.max_ranges == known.max_ranges);
    CHECK(options.outside_weight == known.outside_weight);
    CHECK(options.hysteresis == known.hysteresis);
    REQUIRE(tetrakis_make_terrain(grid.heights.data(), grid.columns, grid.rows, 2, &c_surface) == TETRAKIS_OK);
    check_same(surface, c_surface, 600, {300, -280, 0});
    REQUIRE(tetrakis_make_terrain(grid.heights.data(), grid.columns, grid.rows, 2, &c_surface) == TETRAKIS_OK);
    double height = 0, t = 0;
    std::array<double, 3> normal{};
    REQUIRE(tetrakis_surface_at(c_surface, 11, -13, &height, normal.data()) == 1);
    CHECK(height == surface.at({11, -13})->height);
    CHECK(tetrakis_surface_at(c_surface, -1, 0, &height, nullptr) == 0);
    const std::array<double, 3> from{11, -13, 100}, down{0, 0, -1};
    REQUIRE(tetrakis_surface_hit(c_surface, from.data(), down.data(), 1e9, &t, nullptr) == 1);
    CHECK(t == doctest::Approx(100 - height));
    CHECK(tetrakis_surface_hit(c_surface, from.data(), down.data(), 1, &t, nullptr) == 0);
    CHECK(tetrakis_surface_hit(c_surface, from.data(), down.data(), NAN, &t, nullptr) == 0);
    for (const double length : {1e-200, 1e200})
        CHECK(tetrakis_surface_hit(c_surface, from.data(), std::array{0.0, 0.0, -length}.data(), INFINITY, &t,
                                   nullptr) == 0);
    CHECK(tetrakis_planet_at(c_surface, down.data(), &height, nullptr) == 0);
    CHECK(tetrakis_surface_revision(c_surface) == 0);
    tetrakis_tile_statistics statistics = TETRAKIS_TILE_STATISTICS;
    CHECK(tetrakis_get_tile_statistics(c_surface, &statistics) == TETRAKIS_INVALID_INPUT);
    CHECK(last_error_says("tetrakis_open_tiles()"));
    tetrakis_free_surface(c_surface);
}

TEST_CASE("capi: raw heights whose file says nothing, and what becomes of gaps, in memory and in tiles") {
    const ScratchDir scratch;
    const std::string raw = (scratch / "heights.bin").string(), path = (scratch / "h.tiles").string();
    const auto number = [](int i) { return i == 289 ? 60'000 : i * i % 5003; };  // 289: column 9, row 7
    std::string bytes;
    for (int i = 0; i < 40 * 30; ++i) bytes += {static_cast<char>(number(i) >> 8), static_cast<char>(number(i) & 255)};
    spill(raw, bytes);
    tetrakis_height_options options{
        sizeof options, {3, 2}, 0.01, -5, TETRAKIS_HEIGHTS_RAW16, 40, 0, 1, 1, 60'000, TETRAKIS_GAPS_REFUSED, 3};
    tetrakis_surface *terrain = nullptr, *tiles = nullptr;
    const auto refused = [&](auto member, auto value, const std::string& words) {
        tetrakis_height_options wrong = options;
        wrong.*member = value;
        CHECK(tetrakis_load_terrain(raw.c_str(), &wrong, &terrain) == TETRAKIS_INVALID_INPUT);
        CHECK(last_error_says(words));
        CHECK(tetrakis_write_tiles(raw.c_str(), &wrong, path.c_str()) == TETRAKIS_INVALID_INPUT);
        CHECK(last_error_says(words));
        CHECK(scratch.file_count() == 1);
    };
    refused(&tetrakis_height_options::gaps, TETRAKIS_GAPS_REFUSED, "column 9, row 7 is missing");
    refused(&tetrakis_height_options::gaps, -1, "gaps is -1");
    refused(&tetrakis_height_options::format, 7, "format is 7");
    refused(&tetrakis_height_options::columns, 41u, "not 41 columns");
    refused(&tetrakis_height_options::columns, 0u, "say how many columns");
    refused(&tetrakis_height_options::size, std::size_t{0}, "does not say its size");
    for (const int gaps : {TETRAKIS_GAPS_FILLED, TETRAKIS_GAPS_LEVEL}) {
        CAPTURE(gaps);
        options.gaps = gaps;
        REQUIRE(tetrakis_load_terrain(raw.c_str(), &options, &terrain) == TETRAKIS_OK);
        REQUIRE(tetrakis_write_tiles(raw.c_str(), &options, path.c_str()) == TETRAKIS_OK);
        REQUIRE(tetrakis_open_tiles(path.c_str(), 1 << 26, &tiles) == TETRAKIS_OK);
        for (int i = 3; i < 40 * 30; i += 13) {  // 289, too
            const std::array<double, 3> from{3.0 * (i % 40), -2.0 * (i / 40), 100}, down{0, 0, -1};
            double height = 0, t = 0;
            REQUIRE(tetrakis_surface_at(terrain, from[0], from[1], &height, nullptr) == 1);
            if (i == 289)
                CHECK((height == 3) == (gaps == TETRAKIS_GAPS_LEVEL));
            else
                CHECK(height == doctest::Approx(0.01 * number(i) - 5));
            REQUIRE(tetrakis_surface_hit(tiles, from.data(), down.data(), 1e9, &t, nullptr) == 1);
            CHECK(100 - t == doctest::Approx(height));
        }
        tetrakis_free_surface(terrain);
        tetrakis_free_surface(tiles);
    }
    options.gap_height = NAN;
    CHECK(tetrakis_load_terrain(raw.c_str(), &options, &terrain) == TETRAKIS_INVALID_INPUT);
    CHECK(last_error_says("gap_height"));
}

TEST_CASE("capi: tiles that come while one looks, and tiles that cannot be read") {
    const ScratchDir scratch;
    const std::string heights = (scratch / "h.r32").string(), path = (scratch / "h.tiles").string();
    const HeightGrid grid = rough(1025, 1025, 5);
    spill(heights, std::string(reinterpret_cast<const char*>(grid.heights.data()), 4 * grid.heights.size()));
    tetrakis_surface* tiles = nullptr;
    tetrakis_view* view = nullptr;
    CHECK(tetrakis_write_tiles(heights.c_str(), nullptr, heights.c_str()) == TETRAKIS_INVALID_INPUT);
    REQUIRE(tetrakis_write_tiles(heights.c_str(), nullptr, path.c_str()) == TETRAKIS_OK);
    CHECK(tetrakis_open_tiles(heights.c_str(), 1 << 26, &tiles) == TETRAKIS_INVALID_INPUT);
    CHECK(last_error_says("h.r32"));
    REQUIRE(tetrakis_open_tiles(path.c_str(), 1 << 26, &tiles) == TETRAKIS_OK);
    REQUIRE(tetrakis_make_view(tiles, nullptr, &view) == TETRAKIS_OK);
    const std::uint64_t before = tetrakis_surface_revision(tiles);
    tetrakis_update update = TETRAKIS_UPDATE;
    tetrakis_tile_statistics statistics = TETRAKIS_TILE_STATISTICS;
    const auto update_until = [&](double x, const auto& done) {
        tetrakis_camera camera = TETRAKIS_CAMERA;
        camera.eye[0] = x;
        camera.eye[1] = -x;
        for (int frame = 0; frame < 2000 && !done(); ++frame) {
            if (frame > 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
            REQUIRE(tetrakis_update_view(view, &camera, nullptr, &update) == TETRAKIS_OK);
            REQUIRE(tetrakis_get_tile_statistics(tiles, &statistics) == TETRAKIS_OK);
        }
        CHECK(done());
    };
    update_until(100, [&] { return statistics.loads > 0 && update.waiting == 0; });
    CHECK(tetrakis_surface_revision(tiles) > before);
    CHECK(statistics.cached_bytes > 0);
    double height = 0;
    for (int tries = 0; tetrakis_surface_at(tiles, 112, -107, &height, nullptr) == 0; ++tries) {
        REQUIRE(tries < 1000);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    CHECK(height == double{grid.at(112, 107)});
    CHECK(std::string(statistics.last_error) == "");
    std::filesystem::resize_file(path, 1000);
    update_until(900, [&] { return statistics.failures > 0; });
    CHECK(statistics.wanted > 0);
    CHECK(std::string(statistics.last_error) != "");
    tetrakis_free_view(view);
    tetrakis_free_surface(tiles);
}

TEST_CASE("capi: a planet of six faces is the C++ one") {
    std::array<HeightGrid, 6> grids;
    std::array<const float*, 6> faces{};
    for (unsigned i = 0; i < 6; ++i) faces[i] = (grids[i] = rough(33, 33, i + 1)).heights.data();
    const lod::PlanetSurface planet(grids, {.radius = 200});
    tetrakis_surface* c_planet = nullptr;
    REQUIRE(tetrakis_make_cube_planet(faces.data(), 33, 200, 0, &c_planet) == TETRAKIS_OK);
    double height = 0;
    Vec3d normal{};
    for (int i = 0; i < 100; ++i) {
        const Vec3d out(std::sin(i), std::cos(2 * i), std::sin(3 * i + 1));
        REQUIRE(tetrakis_planet_at(c_planet, &out.x, &height, &normal.x) == 1);
        CHECK(height == doctest::Approx(planet.height(out)));
        CHECK(glm::dot(normal, planet.normal(out)) == doctest::Approx(1));
    }
    for (const double wrong : {0.0, double{NAN}, double{INFINITY}}) {
        const std::array<double, 3> nowhere{0, wrong, 0};
        CHECK(tetrakis_planet_at(c_planet, nowhere.data(), &height, nullptr) == 0);
    }
    check_same(planet, c_planet, 400);
    CHECK(tetrakis_make_cube_planet(faces.data(), 33, -1, 0, &c_planet) == TETRAKIS_INVALID_INPUT);
    faces[4] = nullptr;
    CHECK(tetrakis_make_cube_planet(faces.data(), 33, 200, 0, &c_planet) == TETRAKIS_INVALID_INPUT);
}

TEST_CASE("capi: procedural planes and balls, of the fractal and of one's own functions") {
    const lod::ProceduralHeights fractal = lod::fractal_heights(3, 40, 3, 11);
    tetrakis_procedural_heights heights = TETRAKIS_PROCEDURAL_HEIGHTS, own = heights;
    tetrakis_surface *plane = nullptr, *ball = nullptr, *none = nullptr;
    REQUIRE(tetrakis_make_fractal_heights(3, 40, 3, 11, &heights) == TETRAKIS_OK);
    REQUIRE(tetrakis_make_procedural_plane(1000, 1, &heights, &plane) == TETRAKIS_OK);
    check_same(lod::ProceduralSurface::plane(1000, 1, fractal), plane, 1000);
    REQUIRE(tetrakis_make_procedural_ball(500, 1, &heights, &ball) == TETRAKIS_OK);
    check_same(lod::ProceduralSurface::ball(500, 1, fractal), ball, 1000);
    tetrakis_free_fractal_heights(&heights);
    CHECK(heights.user == nullptr);
    tetrakis_free_fractal_heights(&heights);
    tetrakis_free_fractal_heights(nullptr);

    const auto refused = [&](double finest, const std::string& words) {
        CHECK(tetrakis_make_procedural_plane(100, finest, &own, &none) == TETRAKIS_INVALID_INPUT);
        CHECK(last_error_says(words));
        CHECK(tetrakis_make_procedural_ball(100, finest, &own, &none) == TETRAKIS_INVALID_INPUT);
        CHECK(last_error_says(words));
    };
    refused(1, "is NULL");
    double factor = 2;
    own.height = [](void* user, const double p[3]) { return *static_cast<double*>(user) * std::sin(p[0]); };
    own.deviation = [](void* user, double radius) {
        return *static_cast<double*>(user) * std::min(2.0, radius * radius / 2);
    };
    own.user = &factor;
    own.slope = own.high = 2;
    own.low = -2;
    refused(0, "above 0");
    REQUIRE(tetrakis_make_procedural_plane(100, 0.01, &own, &plane) == TETRAKIS_OK);
    const std::array<double, 3> above{1, 2, 50}, down{0, 0, -1};
    double t = 0;
    REQUIRE(tetrakis_surface_hit(plane, above.data(), down.data(), 100, &t, nullptr) == 1);
    CHECK(50 - t == doctest::Approx(2 * std::sin(1)).epsilon(1e-4));
    tetrakis_free_surface(plane);
    tetrakis_free_fractal_heights(&own);
    CHECK(own.user == &factor);
    factor = NAN;
    refused(1, "deviations have to be finite");
    own.high = -3;
    refused(1, "from -2 to -3");
    CHECK(tetrakis_make_procedural_plane(1, 1, nullptr, &none) == TETRAKIS_INVALID_INPUT);
    CHECK(tetrakis_make_fractal_heights(3, 40, 0, 11, &own) == TETRAKIS_INVALID_INPUT);
    CHECK(none == nullptr);
}

TEST_CASE("capi: planets and subdivision surfaces, and rays that meet what is shown") {
    const HeightGrid map = grid_of(32, 16, [](double c, double r) { return 0.5 * std::sin(c + 32 * r); });
    const std::vector<float>& heights = map.heights;
    tetrakis_surface *planet = nullptr, *same = nullptr;
    REQUIRE(tetrakis_make_planet(heights.data(), 32, 16, 10, 0, &same) == TETRAKIS_OK);
    check_same(lod::PlanetSurface(map, {.radius = 10}), same, 20);
    REQUIRE(tetrakis_make_planet(heights.data(), 32, 16, 10, 0, &planet) == TETRAKIS_OK);
    tetrakis_control_mesh* control = nullptr;
    REQUIRE(tetrakis_load_control_mesh(cli::data("cube.obj").c_str(), &control) == TETRAKIS_OK);
    const ControlMesh mesh = load_control_mesh(cli::data("cube.obj"));
    for (const char* scheme : {"catmull-clark", "doo-sabin", "midedge"}) {
        CAPTURE(scheme);
        REQUIRE(tetrakis_make_subdivision_surface(control, scheme, 4, &same) == TETRAKIS_OK);
        check_same(lod::SubdivisionSurface(mesh, scheme, {.level = 4}), same, 1.6);
    }
    tetrakis_surface* cube = nullptr;
    REQUIRE(tetrakis_make_subdivision_surface(control, "catmull-clark", 3, &cube) == TETRAKIS_OK);
    tetrakis_surface* none = nullptr;
    CHECK(tetrakis_make_subdivision_surface(control, "biquartic", 3, &none) == TETRAKIS_UNSUPPORTED);
    CHECK(tetrakis_make_planet(heights.data(), 32, 16, -1, 0, &none) == TETRAKIS_INVALID_INPUT);
    CHECK(none == nullptr);
    tetrakis_free_control_mesh(control);
    for (tetrakis_surface* surface : {planet, cube}) {
        tetrakis_view* view = nullptr;
        REQUIRE(tetrakis_make_view(surface, nullptr, &view) == TETRAKIS_OK);
        tetrakis_camera camera = TETRAKIS_CAMERA;
        camera.eye[1] = -40;
        tetrakis_update update = TETRAKIS_UPDATE;
        tetrakis_budget budget = TETRAKIS_BUDGET;
        budget.pixel_error = 1e-3;  // all that there is
        REQUIRE(tetrakis_update_view(view, &camera, &budget, &update) == TETRAKIS_OK);
        CHECK(update.leaves > 1000);
        const tetrakis_region everywhere{{0, 0, 0}, 100, 2}, wrong{{0, 0, 0}, 1, 0.5};
        CHECK(tetrakis_set_view_regions(view, &everywhere, 1) == TETRAKIS_OK);
        CHECK(tetrakis_set_view_regions(view, &wrong, 1) == TETRAKIS_INVALID_INPUT);
        CHECK(tetrakis_set_view_regions(view, nullptr, 0) == TETRAKIS_OK);
        tetrakis_snapshot* snapshot = nullptr;
        REQUIRE(tetrakis_take_snapshot(view, &snapshot) == TETRAKIS_OK);
        tetrakis_free_view(view);
        double full = 0, shown = 0, height = 0;
        std::array<double, 3> normal{};
        const std::array<double, 3> direction{0.001, 1, 0.002};
        REQUIRE(tetrakis_surface_hit(surface, camera.eye, direction.data(), 100, &full, nullptr) == 1);
        REQUIRE(tetrakis_snapshot_hit(snapshot, camera.eye, direction.data(), 100, &shown, normal.data()) == 1);
        CHECK(shown == doctest::Approx(full).epsilon(1e-6));
        CHECK(normal[1] < -0.5);
        CHECK(tetrakis_snapshot_hit(snapshot, camera.eye, direction.data(), 0.9 * shown, nullptr, nullptr) == 0);
        CHECK(tetrakis_surface_at(surface, 0, 0, &height, nullptr) == 0);
        const ScratchDir scratch;
        const std::string glb = (scratch / "shown.glb").string(), unknown = (scratch / "shown.txt").string();
        REQUIRE(tetrakis_write_snapshot(snapshot, glb.c_str()) == TETRAKIS_OK);
        CHECK(read_triangle_mesh(glb).triangles.size() == update.leaves);
        CHECK(tetrakis_write_snapshot(snapshot, unknown.c_str()) == TETRAKIS_UNSUPPORTED);
        tetrakis_free_snapshot(snapshot);
        tetrakis_free_surface(surface);
    }
}

TEST_CASE("capi: a tessellation from arrays, by a program that knows fewer options") {
    const std::array<double, 24> positions{-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1,
                                           -1, -1, 1,  1, -1, 1,  -1, 1, 1,  1, 1, 1};
    const std::array<std::uint32_t, 6> sizes{4, 4, 4, 4, 4, 4};
    const std::array<std::uint32_t, 24> faces{0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    tetrakis_control_mesh* control = nullptr;
    tetrakis_mesh* mesh = nullptr;
    REQUIRE(tetrakis_make_control_mesh(positions.data(), 8, sizes.data(), 6, faces.data(), &control) == TETRAKIS_OK);
    tetrakis_tessellate_options options = TETRAKIS_TESSELLATE_OPTIONS;
    options.max_triangles = 1;  // beyond what the program knows, so not looked at
    options.size = offsetof(tetrakis_tessellate_options, max_triangles);
    REQUIRE(tetrakis_tessellate(control, &options, &mesh) == TETRAKIS_OK);
    CHECK(tetrakis_mesh_reached_tolerance(mesh) == 1);
    tetrakis_mesh_arrays arrays = TETRAKIS_MESH_ARRAYS;
    REQUIRE(tetrakis_get_mesh_arrays(mesh, &arrays) == TETRAKIS_OK);
    CHECK(arrays.triangle_count > 100);
    CHECK(arrays.uvs == nullptr);
    double volume = 0;
    for (std::uint32_t i = 0; i < arrays.triangle_count; ++i) {
        std::array<Vec3d, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            const float* at = arrays.positions + 3 * std::size_t{arrays.indices[3 * i + k]};
            p[k] = {at[0], at[1], at[2]};
        }
        volume += glm::dot(p[0], glm::cross(p[1], p[2])) / 6;
    }
    CHECK(volume > 2);  // of the cube's limit surface, about
    CHECK(volume < 4);
    tetrakis_free_mesh(mesh);
    tetrakis_free_control_mesh(control);
}

TEST_CASE("[bad-input] capi: sentences, and nothing that flies") {
    tetrakis_control_mesh* control = nullptr;
    CHECK(tetrakis_load_control_mesh("no/such.obj", &control) == TETRAKIS_IO);
    CHECK(last_error_says("no/such.obj"));
    CHECK(tetrakis_load_control_mesh(nullptr, &control) == TETRAKIS_INVALID_INPUT);
    CHECK(std::string(tetrakis_last_error()) == "path is NULL");
    const std::array<double, 9> positions{};
    const std::array<std::uint32_t, 1> sizes{3};
    const std::array<std::uint32_t, 3> faces{0, 1, 7};
    CHECK(tetrakis_make_control_mesh(positions.data(), 3, sizes.data(), 1, faces.data(), &control) ==
          TETRAKIS_INVALID_INPUT);
    CHECK(control == nullptr);
    REQUIRE(tetrakis_load_control_mesh(cli::data("cube.obj").c_str(), &control) == TETRAKIS_OK);
    tetrakis_mesh* mesh = nullptr;
    tetrakis_tessellate_options options = TETRAKIS_TESSELLATE_OPTIONS;
    options.scheme = "catmull";
    CHECK(tetrakis_tessellate(control, &options, &mesh) == TETRAKIS_INVALID_INPUT);
    options = TETRAKIS_TESSELLATE_OPTIONS;
    options.tolerance = -1;
    CHECK(tetrakis_tessellate(control, &options, &mesh) == TETRAKIS_INVALID_INPUT);
    options.size = 0;
    CHECK(tetrakis_tessellate(control, &options, &mesh) == TETRAKIS_INVALID_INPUT);
    CHECK(mesh == nullptr);
    tetrakis_free_control_mesh(control);
    tetrakis_free_control_mesh(nullptr);

    const std::array<float, 4> heights{0, 1, 2, NAN};
    tetrakis_surface* surface = nullptr;
    CHECK(tetrakis_make_terrain(heights.data(), 2, 2, 1, &surface) == TETRAKIS_INVALID_INPUT);
    CHECK(tetrakis_make_terrain(heights.data(), 3, 1, 1, &surface) == TETRAKIS_INVALID_INPUT);
    CHECK(tetrakis_load_terrain(cli::data("cube.obj").c_str(), nullptr, &surface) != TETRAKIS_OK);
    const std::array<float, 4> plane{};
    REQUIRE(tetrakis_make_terrain(plane.data(), 2, 2, 1, &surface) == TETRAKIS_OK);
    tetrakis_view* view = nullptr;
    REQUIRE(tetrakis_make_view(surface, nullptr, &view) == TETRAKIS_OK);
    tetrakis_camera camera = TETRAKIS_CAMERA;
    camera.direction[1] = 0;
    tetrakis_update update = TETRAKIS_UPDATE;
    CHECK(tetrakis_update_view(view, &camera, nullptr, &update) == TETRAKIS_INVALID_INPUT);
    camera = TETRAKIS_CAMERA;
    CHECK(tetrakis_update_view(view, &camera, nullptr, nullptr) == TETRAKIS_INVALID_INPUT);
    update.size = 0;
    CHECK(tetrakis_update_view(view, &camera, nullptr, &update) == TETRAKIS_INVALID_INPUT);
    update = TETRAKIS_UPDATE;
    REQUIRE(tetrakis_update_view(view, &camera, nullptr, &update) == TETRAKIS_OK);
    CHECK(update.vertex_range_count > 0);  // all of it, still: what failed has changed nothing
    CHECK(tetrakis_surface_at(nullptr, 0, 0, nullptr, nullptr) == 0);
    CHECK(tetrakis_surface_hit(surface, nullptr, nullptr, 1, nullptr, nullptr) == 0);
    CHECK(tetrakis_snapshot_hit(nullptr, nullptr, nullptr, 1, nullptr, nullptr) == 0);
    CHECK(tetrakis_view_triangles(nullptr, nullptr, nullptr) == nullptr);
    CHECK(tetrakis_view_vertices(nullptr, nullptr, nullptr) == nullptr);
    tetrakis_free_view(view);
    tetrakis_free_surface(surface);
}
