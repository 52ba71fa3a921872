#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/terrain_surface.hpp"
#include "../../tools/capi/tetrakis_c.h"

#include "../kit/cli.hpp"
#include "../kit/height_grids.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <thread>
#include <vector>

using namespace tetrakis;
using namespace tetrakis::test;

TEST_CASE("capi: a view is the C++ one's, byte for byte") {
    HeightGrid grid = rough(100, 80, 3);
    grid.spacing = Vec2d(2);
    const lod::TerrainSurface surface(grid);
    lod::View view(surface, {.max_leaves = 5000});
    tetrakis_surface* c_surface = nullptr;
    tetrakis_view* c_view = nullptr;
    REQUIRE(tetrakis_make_terrain(grid.heights.data(), grid.columns, grid.rows, 2, &c_surface) == TETRAKIS_OK);
    tetrakis_view_options options = TETRAKIS_VIEW_OPTIONS;
    options.max_leaves = 5000;
    REQUIRE(tetrakis_make_view(c_surface, &options, &c_view) == TETRAKIS_OK);
    tetrakis_camera c_camera = TETRAKIS_CAMERA;
    tetrakis_budget c_budget = TETRAKIS_BUDGET;
    tetrakis_update c_update = TETRAKIS_UPDATE;
    std::uint32_t count = 0;
    for (int frame = 0; frame < 50; ++frame) {
        lod::Camera camera;
        camera.eye = {2.0 * frame, -150.0 + frame, 60};
        const lod::Update update = view.update(camera);
        for (int k = 0; k < 3; ++k) c_camera.eye[k] = camera.eye[k];
        REQUIRE(tetrakis_update_view(c_view, &c_camera, &c_budget, &c_update) == TETRAKIS_OK);
        REQUIRE(c_update.leaves == update.leaves);
        REQUIRE(c_update.splits == update.splits);
        REQUIRE(c_update.morph_scale == update.morph_scale);
        REQUIRE(c_update.triangle_range_count == update.triangles.size());
        const tetrakis_vertex* vertices = tetrakis_view_vertices(c_view, &count, nullptr);
        REQUIRE(count == view.vertices().size());
        REQUIRE(std::memcmp(vertices, view.vertices().data(), count * sizeof(lod::Vertex)) == 0);
        const std::uint32_t* triangles = tetrakis_view_triangles(c_view, &count, nullptr);
        REQUIRE(count == view.triangles().size());
        REQUIRE(std::memcmp(triangles, view.triangles().data(), count * sizeof(lod::Triangle)) == 0);
    }
    double height = 0, t = 0;
    std::array<double, 3> normal{};
    REQUIRE(tetrakis_surface_at(c_surface, 11, -13, &height, normal.data()) == 1);
    CHECK(height == surface.at({11, -13})->height);
    CHECK(tetrakis_surface_at(c_surface, -1, 0, &height, nullptr) == 0);
    const std::array<double, 3> from{11, -13, 100}, down{0, 0, -1};
    REQUIRE(tetrakis_surface_hit(c_surface, from.data(), down.data(), 1e9, &t) == 1);
    CHECK(t == doctest::Approx(100 - height));
    CHECK(tetrakis_surface_hit(c_surface, from.data(), down.data(), 1, &t) == 0);
    tetrakis_free_view(c_view);
    tetrakis_free_surface(c_surface);
}

TEST_CASE("capi: tiles are the terrain that they were cut from") {
    const ScratchDir scratch;
    const std::string path = (scratch / "island.tiles").string(), island = cli::data("island.png");
    REQUIRE(tetrakis_write_tiles(island.c_str(), 10, 0.1, 0, path.c_str()) == TETRAKIS_OK);
    tetrakis_surface *tiles = nullptr, *terrain = nullptr;
    CHECK(tetrakis_open_tiles(island.c_str(), 1 << 26, &tiles) == TETRAKIS_INVALID_INPUT);
    CHECK(std::string(tetrakis_last_error()).find("island.png") != std::string::npos);
    REQUIRE(tetrakis_open_tiles(path.c_str(), 1 << 26, &tiles) == TETRAKIS_OK);
    REQUIRE(tetrakis_load_terrain(island.c_str(), 10, 0.1, 0, &terrain) == TETRAKIS_OK);
    for (int i = 0; i < 100; ++i) {
        const std::array<double, 3> from{12.3 * i, -7.1 * i, 500}, down{0.1, 0.2, -1};
        double t = 0, other = 0;
        REQUIRE(tetrakis_surface_hit(tiles, from.data(), down.data(), 1e9, &t) ==
                tetrakis_surface_hit(terrain, from.data(), down.data(), 1e9, &other));
        CHECK(t == doctest::Approx(other));
    }
    double height = 0, other_height = 1;
    for (int tries = 0; tetrakis_surface_at(tiles, 12, -7, &height, nullptr) == 0; ++tries) {
        REQUIRE(tries < 1000);
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    REQUIRE(tetrakis_surface_at(terrain, 12, -7, &other_height, nullptr) == 1);
    CHECK(height == doctest::Approx(other_height));
    tetrakis_view* view = nullptr;
    tetrakis_camera camera = TETRAKIS_CAMERA;
    camera.eye[2] = 100;
    tetrakis_update update = TETRAKIS_UPDATE;
    const tetrakis_budget budget = TETRAKIS_BUDGET;
    REQUIRE(tetrakis_make_view(tiles, nullptr, &view) == TETRAKIS_OK);
    REQUIRE(tetrakis_update_view(view, &camera, &budget, &update) == TETRAKIS_OK);
    CHECK(update.leaves > 100);
    CHECK(update.waiting == 0);
    tetrakis_free_view(view);
    tetrakis_free_surface(tiles);
    tetrakis_free_surface(terrain);
}

TEST_CASE("capi: planets and subdivision surfaces, and rays that meet what is shown") {
    std::vector<float> heights;
    for (int i = 0; i < 32 * 16; ++i) heights.push_back(static_cast<float>(0.5 * std::sin(i)));
    tetrakis_surface* planet = nullptr;
    REQUIRE(tetrakis_make_planet(heights.data(), 32, 16, 10, 0, &planet) == TETRAKIS_OK);
    tetrakis_control_mesh* control = nullptr;
    REQUIRE(tetrakis_load_control_mesh(cli::data("cube.obj").c_str(), &control) == TETRAKIS_OK);
    tetrakis_surface* cube = nullptr;
    REQUIRE(tetrakis_make_subdivision_surface(control, "catmull-clark", 3, &cube) == TETRAKIS_OK);
    tetrakis_surface* none = nullptr;
    CHECK(tetrakis_make_subdivision_surface(control, "doo-sabin", 3, &none) == TETRAKIS_UNSUPPORTED);
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
        REQUIRE(tetrakis_surface_hit(surface, camera.eye, direction.data(), 100, &full) == 1);
        REQUIRE(tetrakis_snapshot_hit(snapshot, camera.eye, direction.data(), 100, &shown, normal.data()) == 1);
        CHECK(shown == doctest::Approx(full).epsilon(1e-6));
        CHECK(normal[1] < -0.5);
        CHECK(tetrakis_snapshot_hit(snapshot, camera.eye, direction.data(), 0.9 * shown, nullptr, nullptr) == 0);
        CHECK(tetrakis_surface_at(surface, 0, 0, &height, nullptr) == 0);
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
    CHECK(std::string(tetrakis_last_error()).find("no/such.obj") != std::string::npos);
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
    CHECK(tetrakis_load_terrain(cli::data("cube.obj").c_str(), 0, 1, 0, &surface) != TETRAKIS_OK);
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
    CHECK(tetrakis_surface_hit(surface, nullptr, nullptr, 1, nullptr) == 0);
    CHECK(tetrakis_snapshot_hit(nullptr, nullptr, nullptr, 1, nullptr, nullptr) == 0);
    CHECK(tetrakis_view_triangles(nullptr, nullptr, nullptr) == nullptr);
    CHECK(tetrakis_view_vertices(nullptr, nullptr, nullptr) == nullptr);
    tetrakis_free_view(view);
    tetrakis_free_surface(surface);
}
