#include "../../eval/lod/view.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../eval/lod_terrain/terrain_tiles.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../eval/terrain/height_source.hpp"
#include "../../hier/base/error.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/judged_terrain.hpp"
#include "../kit/lod_walks.hpp"
#include "../kit/scratch_dir.hpp"
#include "../kit/surface_topology.hpp"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <latch>
#include <limits>
#include <random>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

using namespace tetrakis;
using namespace tetrakis::test;
using namespace std::chrono_literals;

namespace {

/// A rough terrain and its file of small tiles.
struct TiledGrid {
    TiledGrid(std::uint32_t columns, std::uint32_t rows, const Vec2d& origin = {1000, -500},
              const Vec2d& spacing = {2, 3})
        : grid(rough(columns, rows, 5)) {
        grid.spacing = spacing;
        grid.origin = origin;
        lod::write_tiles(*make_height_source(grid), path, {.side = 16});
    }
    /// Reads the file as TiledTerrain does by default.
    void read(std::uint64_t offset, std::span<std::byte> bytes) const {
        std::ifstream file(path, std::ios::binary);
        file.seekg(static_cast<std::streamoff>(offset));
        file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
    HeightGrid grid;
    ScratchDir dir;
    std::filesystem::path path = dir / "terrain.tiles";
};

// A tile of 16 steps takes about 2.7 kB.
constexpr std::uint64_t k_small_cache = 64 << 10;

std::set<std::array<Site, 3>> leaves(const lod::View& view) {
    const auto list = view.leaves();
    return {list.begin(), list.end()};
}

/// Bytes of all vertices in use, sorted.
std::vector<std::string> vertex_bytes(const lod::View& view) {
    std::set<std::uint32_t> numbers;
    for (const lod::Triangle& t : used(view)) numbers.insert(t.begin(), t.end());
    std::vector<std::string> bytes;
    for (const std::uint32_t v : numbers)
        bytes.emplace_back(reinterpret_cast<const char*>(&view.vertices()[v]), sizeof(lod::Vertex));
    std::sort(bytes.begin(), bytes.end());
    return bytes;
}

/// Updates until no tile is left to be loaded.
lod::Update rest(lod::View& view, const lod::TiledTerrain& terrain, const lod::Camera& camera,
                 const lod::Budget& budget) {
    for (;;) {
        const std::uint64_t revision = terrain.revision();
        const lod::Update update = view.update(camera, budget);
        if (update.waiting == 0) return update;
        terrain.wait(revision);
    }
}

std::string tile_fault(const std::filesystem::path& path, const lod::TiledTerrainOptions& options = {}) {
    const Error error = error_of([&] { const lod::TiledTerrain terrain(path, options); });
    CHECK(error.file() == path);
    return error.what();
}

}  // namespace

TEST_CASE("lod tiles: loaded tiles keep the promise at every sample, at any size, as the terrain in memory does") {
    for (const auto& [columns, rows] : {std::pair{129u, 129u}, {150u, 97u}, {60u, 201u}, {3u, 2u}}) {
        CAPTURE(columns);
        const TiledGrid tiled(columns, rows);
        const lod::TiledTerrain terrain(tiled.path);
        const lod::TerrainSurface surface(tiled.grid);
        lod::View view(terrain, {.max_leaves = 100'000}), whole(surface, {.max_leaves = 100'000});
        Wanderer wanderer(tiled.grid, 7);
        for (int frame = 0; frame < 90; ++frame) {
            const lod::Camera camera = wanderer.next();
            REQUIRE(whole.update(camera, {.pixel_error = 2}).pixel_error == 2);
            if (frame % 9 != 0) {
                view.update(camera, {.pixel_error = 2});
                continue;
            }
            const lod::Update update = rest(view, terrain, camera, {.pixel_error = 2});
            check_whole(view, tiled.grid);
            REQUIRE(update.pixel_error == 2);
            for (const lod::View* of : {&view, &whole}) REQUIRE(judged_pixels(*of, tiled.grid, camera) <= 2 + 1e-3);
            check_whole(whole, tiled.grid);
        }
        CHECK(terrain.statistics().failures == 0);
        // The finest mesh has the samples themselves.
        rest(view, terrain, {.eye = {1000, -500, 3}}, {.pixel_error = 1e-12});
        whole.update({.eye = {1000, -500, 3}}, {.pixel_error = 1e-12});
        const TriangleMesh mesh = view.mesh(), other = whole.mesh();
        CHECK(mesh.triangles.size() == other.triangles.size());
        const auto sorted = [](const TriangleMesh& of) {
            std::vector<std::array<double, 3>> points;
            for (const Vec3d& p : of.positions) points.push_back({p.x, p.y, p.z});
            std::sort(points.begin(), points.end());
            return points;
        };
        CHECK(sorted(mesh) == sorted(other));
        double largest = 0;
        for (std::size_t i = 0; i < mesh.normals.size(); ++i)
            largest = std::max(largest, std::abs(glm::length(mesh.normals[i]) - 1));
        CHECK(largest < 1e-12);
    }
}

TEST_CASE("lod tiles: with a small cache and a slow, failing loader no frame has a hole, and nothing is lost") {
    const TiledGrid tiled(200, 141);
    std::atomic<int> calls = 0;
    const lod::TiledTerrain terrain(
        tiled.path, {.cache_bytes = k_small_cache, .pause = 1ms, .read = [&](std::uint64_t offset, auto bytes) {
                         const int call = ++calls;
                         if (call % 7 == 0) std::this_thread::sleep_for(2ms);
                         if (call % 3 == 0) throw std::runtime_error("the line is down");
                         tiled.read(offset, bytes);
                         // Bytes that arrive can also be damaged.
                         if (call % 5 == 0) bytes[bytes.size() / 2] ^= std::byte{4};
                     }});
    const lod::TiledTerrain sure(tiled.path);
    // Hysteresis depends on the camera's way, so new views are compared.
    Wanderer wanderer(tiled.grid, 3);
    lod::View view(terrain, {.max_leaves = 200'000});
    for (int frame = 0; frame < 120; ++frame) {
        const lod::Camera camera = wanderer.next();
        const lod::Update update = view.update(camera, {.pixel_error = 2});
        REQUIRE(update.complete);
        REQUIRE(terrain.statistics().cached_bytes <= k_small_cache);
        if (frame % 10 == 9) view.set_origin(camera.eye);
        if (frame % 5 == 0) check_whole(view, tiled.grid);
        if (frame % 40 != 39) continue;
        rest(view, terrain, camera, {.pixel_error = 2});
        check_whole(view, tiled.grid);
        REQUIRE(judged_pixels(view, tiled.grid, camera) <= 2 + 1e-3);

        lod::View late(terrain, {.max_leaves = 200'000}), early(sure, {.max_leaves = 200'000});
        rest(late, terrain, camera, {.pixel_error = 2});
        rest(early, sure, camera, {.pixel_error = 2});
        REQUIRE(leaves(late) == leaves(early));
        REQUIRE(vertex_bytes(late) == vertex_bytes(early));
        REQUIRE(late.leaf_count() > 2000);
        // For tiles that were dropped, the mesh has the positions of the buffer.
        const TriangleMesh mesh = late.mesh(), other = early.mesh();
        REQUIRE(mesh.positions.size() == other.positions.size());
        for (const auto* of : {&mesh, &other})
            for (std::size_t i = 0; i < of->normals.size(); ++i) REQUIRE(std::isfinite(of->normals[i].z));
    }
    const lod::TileStatistics statistics = terrain.statistics();
    CHECK(statistics.failures > 20);
    CHECK(statistics.loads > 200);
    CHECK(!statistics.last_error.empty());
    CHECK(sure.statistics().failures == 0);
}

TEST_CASE("lod tiles: updates return while the loader is blocked, and several views share a terrain") {
    const TiledGrid tiled(200, 141);
    std::latch opened(1);
    std::atomic<bool> is_open = false;
    {
        const lod::TiledTerrain terrain(tiled.path,
                                        {.cache_bytes = k_small_cache, .read = [&](std::uint64_t offset, auto bytes) {
                                             opened.wait();
                                             tiled.read(offset, bytes);
                                         }});
        const auto walk = [&](unsigned seed) {
            Wanderer wanderer(tiled.grid, seed);
            lod::View view(terrain, {.max_leaves = 50'000});
            lod::Camera camera;
            lod::Update update;
            for (int frame = 0; frame < 60; ++frame) {
                camera = wanderer.next();
                update = view.update(camera, {.pixel_error = 2});
            }
            // The coarsest levels are shown while finer ones are loaded.
            const bool waited = update.waiting > 0 && update.leaves > 4;
            const auto before = view.leaf_count();
            if (!is_open.exchange(true)) opened.count_down();
            rest(view, terrain, camera, {.pixel_error = 2});
            return waited && view.leaf_count() > before;
        };
        bool first = walk(1);
        CHECK(first);
        CHECK(terrain.statistics().loads > 0);
        // Two threads with one view each.
        std::vector<int> done(2);
        {
            std::vector<std::jthread> threads;
            for (unsigned i = 0; i < 2; ++i)
                threads.emplace_back([&, i] {
                    Wanderer wanderer(tiled.grid, 10 + i);
                    lod::View view(terrain, {.max_leaves = 50'000});
                    for (int frame = 0; frame < 60; ++frame) {
                        const lod::Camera camera = wanderer.next();
                        view.update(camera, {.pixel_error = 2});
                        if (frame % 20 == 19 && rest(view, terrain, camera, {.pixel_error = 2}).waiting == 0) ++done[i];
                    }
                });
        }
        CHECK(done == std::vector<int>{3, 3});
        CHECK(terrain.statistics().cached_bytes <= k_small_cache);
    }
}

TEST_CASE("lod tiles: a still view without room for more leaves gets the tiles it waits for, however small the cache") {
    const TiledGrid tiled(200, 141);
    const lod::TiledTerrain terrain(tiled.path, {.cache_bytes = k_small_cache / 2});
    Wanderer wanderer(tiled.grid, 10);
    const lod::Camera camera = wanderer.next();
    lod::View view(terrain, {.max_leaves = 50'000});
    lod::Update update;
    const auto begin = std::chrono::steady_clock::now();
    do {
        const std::uint64_t revision = terrain.revision();
        update = view.update(camera, {.pixel_error = 2});
        terrain.wait(revision, 1ms);
    } while (update.waiting > 0 && std::chrono::steady_clock::now() - begin < 30s);
    CHECK(update.waiting == 0);
    CHECK(update.pixel_error > 2);
    CHECK(terrain.statistics().loads > 200);
}

TEST_CASE("lod tiles: the ground is that of the samples, or not known yet, while a view walks and with none") {
    const TiledGrid tiled(200, 141);
    const lod::TerrainSurface whole(tiled.grid);
    const lod::TiledTerrain terrain(tiled.path, {.cache_bytes = k_small_cache});
    std::atomic<bool> is_over = false;
    std::size_t known = 0, wrong = 0;
    const auto ask = [&](const Vec2d& place) {
        const auto ground = terrain.at(place), expected = whole.at(place);
        if (!ground) return !expected;
        ++known;
        if (!expected || ground->height != expected->height || ground->normal != expected->normal) ++wrong;
        const auto hit = terrain.hit({place.x, place.y, 1e3}, {0, 0, -1});
        if (!hit || !(hit->normal.z > 0)) ++wrong;
        return true;
    };
    std::mt19937 random(2);
    std::uniform_real_distribution<double> one(0, 1);
    const auto place = [&] { return Vec2d(990 + 420 * one(random), -490 - 440 * one(random)); };
    {
        std::jthread games([&] {
            while (!is_over) ask(place());
        });
        Wanderer wanderer(tiled.grid, 5);
        lod::View view(terrain, {.max_leaves = 50'000});
        lod::Camera camera;
        for (int frame = 0; frame < 60; ++frame) view.update(camera = wanderer.next(), {.pixel_error = 2});
        is_over = true;
        games.join();
        check_whole(view, tiled.grid);
    }
    // Without views, and with more tiles than fit into the cache, each query is answered after enough calls.
    for (int i = 0; i < 100; ++i)
        for (const Vec2d at = place(); !ask(at);) std::this_thread::sleep_for(100us);
    CHECK(known > 50);
    CHECK(wrong == 0);
    CHECK(terrain.statistics().loads > 50);
    CHECK(terrain.statistics().cached_bytes <= k_small_cache);
}

TEST_CASE("lod tiles: random places come from all tiles, although few fit into the cache") {
    const TiledGrid tiled(200, 141);
    const lod::TiledTerrain terrain(tiled.path, {.cache_bytes = k_small_cache});
    std::set<double> seen;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        const std::uint64_t revision = terrain.revision();
        for (const Vec3d& place : lod::random_places(terrain, 4, seed / 2)) seen.insert(place.x);
        terrain.wait(revision, 10s);
    }
    CHECK(seen.size() > 150);
}

TEST_CASE("lod tiles: rays straight down meet the border, where coordinates are rounded, too") {
    const TiledGrid tiled(57, 41, {0.1, -0.7}, {0.3, 0.3});
    const lod::TiledTerrain terrain(tiled.path);
    for (int i = 0; i < 57 * 41; ++i) {
        const Vec2d place = tiled.grid.origin + tiled.grid.spacing * Vec2d(i % 57, -(i / 57));
        REQUIRE(terrain.hit({place, 1e4}, {0, 0, -1}));
    }
}

TEST_CASE("lod tiles: where some tiles are missing for good no ray passes between the triangles that are known") {
    const TiledGrid tiled(200, 141);
    const lod::TiledTerrain terrain(tiled.path, {.pause = 1h, .read = [&](std::uint64_t offset, auto bytes) {
                                                     if (offset / bytes.size() % 3 == 0) throw std::runtime_error("no");
                                                     tiled.read(offset, bytes);
                                                 }});
    lod::View everything(terrain);
    // Until no tile has been loaded for half a second.
    for (std::uint64_t revision = 1, before = 0; revision != before; revision = terrain.revision()) {
        before = terrain.revision();
        everything.update({}, {.pixel_error = 1e-12});
        terrain.wait(before, 500ms);
    }
    REQUIRE(terrain.statistics().failures > 10);
    REQUIRE(everything.leaf_count() > 10'000);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> one(0, 1);
    std::size_t missed = 0;
    for (int i = 0; i < 5'000; ++i)
        if (!terrain.hit({1000 + 398 * one(random), -500 - 420 * one(random), 1e3}, {0, 0, -1})) ++missed;
    CHECK(missed == 0);
}

TEST_CASE("lod tiles: vertices of tiles that are gone keep their places in another frame") {
    const TiledGrid tiled(200, 141);
    const lod::TiledTerrain terrain(tiled.path, {.cache_bytes = k_small_cache});
    lod::View view(terrain, {.max_leaves = 200'000});
    const lod::Camera camera{.eye = {1200, -700, 10}, .direction = {0, 1, -0.5}};
    rest(view, terrain, camera, {.pixel_error = 2});
    std::vector<Vec3d> before;
    for (std::uint32_t v = 0; v < view.vertices().size(); ++v) before.push_back(position(view, v));
    view.set_origin({1200, -700, 0});
    view.update(camera, {.pixel_error = 2});
    double largest = 0;
    for (std::uint32_t v = 0; v < before.size(); ++v)
        largest = std::max(largest, glm::length(position(view, v) - before[v]));
    CHECK(largest < 1e-3);
    check_whole(view, tiled.grid);
}

TEST_CASE("lod tiles: [bad-input] files that are none, cut off, damaged or newer are refused by name") {
    const TiledGrid tiled(40, 30);
    const std::string good = slurp(tiled.path);
    const std::filesystem::path path = tiled.dir / "bad.tiles";
    const auto fault_of = [&](const std::string& bytes) {
        spill(path, bytes);
        return tile_fault(path);
    };
    CHECK(contains(tile_fault(tiled.dir / "none.tiles"), "no such file"));
    CHECK(contains(tile_fault(tiled.dir.path()), "no regular file"));
    spill(path, good);
    CHECK_NOTHROW(lod::TiledTerrain{path});
    CHECK(contains(fault_of(""), "no tile file"));
    CHECK(contains(fault_of("P6 800 600 255"), "no tile file"));
    for (std::size_t size = 8; size < good.size(); size += size < 80 ? 1 : 997)
        CHECK(contains(fault_of(good.substr(0, size)), "cut off"));
    CHECK(contains(fault_of(good + "x"), "cut off or damaged"));
    const auto with = [&](std::size_t at, std::uint32_t number) {
        std::string bytes = good;
        std::memcpy(bytes.data() + at, &number, sizeof number);
        return fault_of(bytes);
    };
    CHECK(contains(with(8, 1), "version 1"));
    CHECK(contains(with(12, 0x04030201), "byte order"));
    for (std::size_t at = 16; at < 64; at += 4) CHECK(contains(with(at, 31), "damaged: its header"));
    CHECK(contains(with(good.size() - 100, 1), "is damaged"));
    CHECK(contains(tile_fault(tiled.path, {.cache_bytes = 4096}), "too small"));

    HeightGrid grid = tiled.grid;
    grid.heights[47] = std::numeric_limits<float>::quiet_NaN();
    const auto write_fault = [&](const lod::TileOptions& options, const std::filesystem::path& to) {
        const Error error = error_of([&] { lod::write_tiles(*make_height_source(grid), to, options); });
        return std::string(error.what());
    };
    const std::size_t files = tiled.dir.file_count();
    CHECK(contains(write_fault({}, tiled.dir / "new.tiles"), "column 7, row 1"));
    CHECK(contains(write_fault({.missing_height = std::numeric_limits<float>::infinity()}, tiled.dir / "new.tiles"),
                   "no finite number"));
    CHECK(contains(write_fault({.side = 48}, tiled.dir / "new.tiles"), "tiles of 48 steps"));
    CHECK(contains(write_fault({}, tiled.dir / "no" / "new.tiles"), "create it first"));
    const RunContext stop{.progress = [](std::string_view, double fraction) { return fraction < 0.5; }};
    CHECK(contains(write_fault({.side = 16, .missing_height = 0.0f, .context = stop}, tiled.dir / "new.tiles"),
                   "cancelled"));
    CHECK(tiled.dir.file_count() == files);
    lod::write_tiles(*make_height_source(grid), tiled.dir / "new.tiles", {.missing_height = 0.0f});
    grid.heights[47] = std::numeric_limits<float>::infinity();
    CHECK(contains(write_fault({.missing_height = 0.0f}, tiled.dir / "worse.tiles"), "column 7, row 1 is larger"));
    CHECK_NOTHROW(lod::TiledTerrain(tiled.dir / "new.tiles"));
    REQUIRE(::mkfifo((tiled.dir / "fifo").c_str(), 0600) == 0);
    CHECK(contains(tile_fault(tiled.dir / "fifo"), "no regular file"));
    CHECK(contains(write_fault({.missing_height = 0.0f}, tiled.dir / "fifo"), "no regular file"));
    // A link stays a link.
    std::filesystem::create_symlink("linked.tiles", tiled.dir / "link.tiles");
    lod::write_tiles(*make_height_source(tiled.grid), tiled.dir / "link.tiles");
    CHECK(std::filesystem::is_symlink(tiled.dir / "link.tiles"));
    CHECK_NOTHROW(lod::TiledTerrain(tiled.dir / "linked.tiles"));
}

TEST_CASE("lod tiles: a file of raw numbers gives the same tiles as its grid, for any number of threads") {
    const ScratchDir dir;
    const HeightGrid grid = rough(143, 71, 4);
    spill(dir / "h.r32", std::string(reinterpret_cast<const char*>(grid.heights.data()), 4 * grid.heights.size()));
    lod::write_tiles(*make_height_source(grid), dir / "a.tiles",
                     {.side = 16, .context = {.threads = 1, .progress = {}}});
    const auto source = open_height_source(dir / "h.r32", {.columns = 143});
    lod::write_tiles(*source, dir / "b.tiles", {.side = 16, .context = {.threads = 3, .progress = {}}});
    CHECK(slurp(dir / "a.tiles") == slurp(dir / "b.tiles"));
}
