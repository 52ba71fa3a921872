#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/planet_surface.hpp"
#include "../../eval/lod_surfaces/subdivision_surface.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../eval/lod_terrain/terrain_tiles.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../eval/terrain/terrain_mesh.hpp"
#include "../../hier/base/memory.hpp"

#include "bench_models.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

// View-dependent LOD: a fractal terrain, mirrored to any size, and cameras that fly over it, stand still and jump. Only
// the surface uses several threads. `changes` are splits and merges of diamonds; times are per frame, in milliseconds.
namespace tetrakis::bench {

namespace {

constexpr double k_spacing = 20;  // between samples; heights are some thousands

/// A fractal terrain by the diamond-square algorithm (Fournier, Fussell, Carpenter 1982).
HeightGrid fractal(std::uint32_t side) {
    HeightGrid grid{.columns = side, .rows = side, .heights = std::vector<float>(std::size_t{side} * side, 0.0f)};
    grid.spacing = Vec2d(k_spacing);
    std::mt19937 random(1);
    std::uniform_real_distribution<float> one(-1, 1);
    const auto at = [&](std::int64_t x, std::int64_t y) -> float& {
        const auto last = static_cast<std::int64_t>(side) - 1;
        x = std::abs(x), y = std::abs(y);
        x = x > last ? 2 * last - x : x, y = y > last ? 2 * last - y : y;
        return grid.heights[static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x)];
    };
    float rough = 4000;
    for (std::int64_t s = (side - 1) / 2; s > 0; s /= 2, rough *= 0.52f) {
        for (std::int64_t y = s; y < side; y += 2 * s)
            for (std::int64_t x = s; x < side; x += 2 * s)
                at(x, y) = (at(x - s, y - s) + at(x + s, y - s) + at(x - s, y + s) + at(x + s, y + s)) / 4 +
                           rough * one(random);
        for (std::int64_t y = 0; y < side; y += s)
            for (std::int64_t x = y / s % 2 == 0 ? s : 0; x < side; x += 2 * s)
                at(x, y) = (at(x - s, y) + at(x + s, y) + at(x, y - s) + at(x, y + s)) / 4 + 0.7f * rough * one(random);
    }
    return grid;
}

std::uint32_t mirrored_place(std::uint32_t i, std::uint32_t count) {
    i %= 2 * (count - 1);
    return i < count ? i : 2 * (count - 1) - i;
}

/// A terrain mirrored to any size. Only one square tile of it is in memory.
class MirroredSource final : public HeightSource {
  public:
    MirroredSource(HeightGrid tile, std::uint32_t columns, std::uint32_t rows) : tile_(std::move(tile)) {
        frame_.columns = columns;
        frame_.rows = rows;
        frame_.spacing = Vec2d(k_spacing);
    }
    explicit MirroredSource(std::uint32_t side) : MirroredSource(fractal(1025), side, side) {}
    const HeightGrid& frame() const override { return frame_; }
    void read(std::uint32_t first_row, std::uint32_t count, std::span<float> heights) override {
        for (std::uint32_t y = 0; y < count; ++y)
            for (std::uint32_t x = 0; x < frame_.columns; ++x)
                heights[y * std::size_t{frame_.columns} + x] =
                    tile_.at(mirrored_place(x, tile_.columns), mirrored_place(first_row + y, tile_.columns));
    }

  private:
    HeightGrid tile_, frame_;
};

HeightGrid all_of(MirroredSource source) {
    HeightGrid grid = source.frame();
    grid.heights.resize(std::size_t{grid.columns} * grid.rows);
    source.read(0, grid.rows, grid.heights);
    return grid;
}
HeightGrid mirrored(std::uint32_t side) { return all_of(MirroredSource(side)); }

/// The terrain of this size. The last one is cached, because the largest takes long to make.
const lod::TerrainSurface& surface(std::uint32_t side) {
    static std::unique_ptr<lod::TerrainSurface> kept;
    if (!kept || kept->grid().columns != side) {
        kept.reset();
        kept = std::make_unique<lod::TerrainSurface>(mirrored(side));
    }
    return *kept;
}

/// A camera that circles the middle of the first 1025 samples at a constant height above the highest ground.
class Flight {
  public:
    Flight(const HeightGrid& grid, double speed) : step_(speed / k_radius) {
        for (const float height : grid.heights) highest_ = std::max(highest_, height);
    }
    lod::Camera next() {
        turn_ += step_;
        lod::Camera camera;
        camera.eye = {k_middle + k_radius * std::cos(turn_), -k_middle + k_radius * std::sin(turn_), highest_ + 300.0};
        camera.direction = {-std::sin(turn_), std::cos(turn_), -0.5};
        return camera;
    }

  private:
    static constexpr double k_radius = 6000, k_middle = 512 * k_spacing;
    double step_, turn_ = 0;
    float highest_ = 0;
};

double milliseconds_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

void report_frames(benchmark::State& state, std::vector<double> times, double changes) {
    std::sort(times.begin(), times.end());
    const auto frames = static_cast<double>(times.size());
    state.counters["median"] = times[times.size() / 2];
    state.counters["p99.9"] = times[static_cast<std::size_t>(0.999 * (frames - 1))];
    state.counters["changes"] = changes / frames;
}

/// @param next  returns the camera of the next frame
template <class Next>
void measure_flight(benchmark::State& state, const lod::Surface& surface, std::uint32_t most_leaves, const Next& next) {
    lod::View view(surface, {.max_leaves = most_leaves});
    const lod::Budget budget{.pixel_error = 0.1};
    for (int i = 0; i < 101; ++i) view.update(next(), budget);
    std::vector<double> times;
    double changes = 0, bytes = 0, leaves = 0;
    for (auto _ : state) {
        const lod::Camera camera = next();
        const auto begin = std::chrono::steady_clock::now();
        const lod::Update update = view.update(camera, budget);
        times.push_back(milliseconds_since(begin));
        changes += update.splits + update.merges;
        leaves = update.leaves;
        for (const auto& range : update.vertices) bytes += range.count * sizeof(lod::Vertex);
        for (const auto& range : update.triangles) bytes += range.count * sizeof(lod::Triangle);
    }
    report_frames(state, times, changes);
    state.counters["bytes_a_change"] = bytes / std::max(1.0, changes);
    state.counters["leaves"] = leaves;
    state.counters["bytes_a_leaf"] = static_cast<double>(view.memory_bytes()) / leaves;
}

/// Arguments: samples along a side; thousands of leaves; length of the camera's way in a frame.
void fly(benchmark::State& state) {
    const lod::TerrainSurface& terrain = surface(static_cast<std::uint32_t>(state.range(0)));
    Flight flight(terrain.grid(), static_cast<double>(state.range(2)));
    measure_flight(state, terrain, static_cast<std::uint32_t>(state.range(1)) * 1000, [&] { return flight.next(); });
}
BENCHMARK(fly)
    ->Args({1025, 200, 8})
    ->Args({1025, 200, 40})
    ->Args({1025, 1000, 10})
    ->Args({4097, 200, 40})
    ->Args({16385, 200, 40})
    ->Iterations(2000)
    ->Unit(benchmark::kMillisecond);

/// Mount Fuji; no samples, with the benchmark skipped, where the shared test data are not here.
HeightGrid fuji(benchmark::State& state) {
    const std::filesystem::path path = shared_folder() / "data/terrain/fuji-terrain-rgb.png";
    if (std::filesystem::exists(path)) return load_height_grid(path);
    state.SkipWithError("the shared test data are not here");
    return {};
}

/// Over Mount Fuji, mirrored, with the fractal's sample spacing. Argument: length of the camera's way in a frame.
void fly_over_fuji(benchmark::State& state) {
    HeightGrid tile = fuji(state);
    if (tile.rows == 0) return;
    const lod::TerrainSurface terrain(all_of(MirroredSource(std::move(tile), 4097, 4097)));
    Flight flight(terrain.grid(), static_cast<double>(state.range(0)));
    measure_flight(state, terrain, 200'000, [&] { return flight.next(); });
}
BENCHMARK(fly_over_fuji)->Arg(40)->Iterations(2000)->Unit(benchmark::kMillisecond);

/// Around the earth, 1000 km above the fractal terrain. Argument: metres of the camera's way in a frame.
void fly_around_planet(benchmark::State& state) {
    const lod::PlanetSurface planet(all_of(MirroredSource(fractal(1025), 4096, 2048)));
    double turn = 0;
    measure_flight(state, planet, 200'000, [&] {
        turn += static_cast<double>(state.range(0)) / planet.radius();
        const Vec3d up(std::cos(turn), std::sin(turn), 0), ahead(-up.y, up.x, 0);
        return lod::Camera{.eye = (planet.radius() + 1e6) * up, .direction = ahead - 0.5 * up, .up = up};
    });
}
BENCHMARK(fly_around_planet)->Arg(20000)->Iterations(2000)->Unit(benchmark::kMillisecond);

/// Close to the limit surface of suzanne, around it. Argument: frames of one turn.
void fly_around_suzanne(benchmark::State& state) {
    const std::filesystem::path path = shared_folder() / "data/models/suzanne.obj";
    if (!std::filesystem::exists(path)) return state.SkipWithError("the shared test data are not here");
    const ControlMesh mesh = load_control_mesh(path);
    const lod::SubdivisionSurface suzanne(mesh, "catmull-clark", {.level = 6});
    const Box3d box = mesh.bounding_box();
    double turn = 0;
    measure_flight(state, suzanne, 200'000, [&] {
        turn += 2 * M_PI / static_cast<double>(state.range(0));
        const Vec3d out(std::cos(turn), 0, std::sin(turn));
        return lod::Camera{.eye = box.centre() + 0.6 * box.diagonal() * out, .direction = -out, .up = {0, 1, 0}};
    });
}
BENCHMARK(fly_around_suzanne)->Arg(1000)->Iterations(2000)->Unit(benchmark::kMillisecond);

void stand_still(benchmark::State& state) {
    const lod::TerrainSurface& terrain = surface(1025);
    lod::View view(terrain, {.max_leaves = static_cast<std::uint32_t>(state.range(0)) * 1000});
    const lod::Camera camera = Flight(terrain.grid(), 0).next();
    view.update(camera, {.pixel_error = 0.1});
    for (auto _ : state) benchmark::DoNotOptimize(view.update(camera, {.pixel_error = 0.1}));
}
BENCHMARK(stand_still)->Arg(200)->Arg(1000)->Unit(benchmark::kMicrosecond);

/// Jumps between the two ends of the terrain with a million leaves. Argument: milliseconds of an update; 0: no limit.
void teleport(benchmark::State& state) {
    const lod::TerrainSurface& terrain = surface(4097);
    lod::View view(terrain, {.max_leaves = 1'000'000});
    const auto from = [&](double x) {
        lod::Camera camera;
        camera.eye = {x, -40000, 9000};
        camera.direction = {0, 1, -0.5};
        return camera;
    };
    const double budget = static_cast<double>(state.range(0));
    view.update(from(10000), {.pixel_error = 0.1});
    bool there = false;
    double longest = 0, frames = 0, jumps = 0;
    for (auto _ : state) {
        const lod::Camera camera = from(there ? 10000 : 70000);
        there = !there;
        ++jumps;
        lod::Update update;
        do {
            const auto begin = std::chrono::steady_clock::now();
            update = view.update(camera, {.pixel_error = 0.1, .milliseconds = budget});
            longest = std::max(longest, milliseconds_since(begin));
            ++frames;
        } while (!update.complete);
    }
    state.counters["longest"] = longest;
    state.counters["frames"] = frames / jumps;
}
BENCHMARK(teleport)->Arg(0)->Arg(4)->Iterations(6)->Unit(benchmark::kMillisecond);

void make_surface(benchmark::State& state) {
    const HeightGrid grid = mirrored(static_cast<std::uint32_t>(state.range(0)));
    for (auto _ : state) {
        const lod::TerrainSurface terrain(grid);
        benchmark::DoNotOptimize(terrain.max_depth());
    }
    state.counters["ns_a_sample"] =
        benchmark::Counter(static_cast<double>(grid.heights.size()) * 1e-9,
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(make_surface)->Arg(1025)->Arg(4097)->Unit(benchmark::kMillisecond);

/// One mesh of the whole grid.
void measure_mesh(benchmark::State& state, const HeightGrid& grid, const TerrainOptions& options) {
    std::size_t triangles = 0;
    for (auto _ : state) triangles = terrain_mesh(grid, options).mesh.triangles.size();
    state.counters["triangles"] = static_cast<double>(triangles);
    state.counters["us_a_triangle"] =
        benchmark::Counter(static_cast<double>(triangles) * 1e-6,
                           benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
    state.counters["peak_bytes"] = static_cast<double>(peak_memory_bytes());
}

/// By all threads. Arguments: samples along a side; error.
void mesh_terrain(benchmark::State& state) {
    measure_mesh(state, mirrored(static_cast<std::uint32_t>(state.range(0))),
                 {.max_error = static_cast<double>(state.range(1))});
}
BENCHMARK(mesh_terrain)->Args({4097, 45})->Args({16385, 45})->Unit(benchmark::kMillisecond)->UseRealTime();

/// By one thread. Argument: error in metres.
void mesh_fuji(benchmark::State& state) {
    const HeightGrid grid = fuji(state);
    TerrainOptions options{.max_error = static_cast<double>(state.range(0))};
    options.context.threads = 1;
    if (grid.rows != 0) measure_mesh(state, grid, options);
}
BENCHMARK(mesh_fuji)->Arg(1)->Arg(5)->Arg(10)->Arg(30)->Unit(benchmark::kMillisecond);

std::filesystem::path tiles_path(std::uint32_t side) {
    return std::filesystem::temp_directory_path() / ("tetrakis_bench_" + std::to_string(side) + ".tiles");
}

/// Writes a file of 11.5 bytes a sample, which fly_tiles reads.
void write_tiles(benchmark::State& state) {
    MirroredSource source(static_cast<std::uint32_t>(state.range(0)));
    for (auto _ : state) lod::write_tiles(source, tiles_path(source.frame().columns));
    state.counters["peak_bytes"] = static_cast<double>(peak_memory_bytes());
}
BENCHMARK(write_tiles)->Arg(4097)->Arg(16385)->Iterations(1)->Unit(benchmark::kMillisecond);

/// Straight across tiles, 60 frames a second. Arguments: samples along a side; MiB of tiles in memory; length of the
/// camera's way in a frame.
void fly_tiles(benchmark::State& state) {
    const MirroredSource source(static_cast<std::uint32_t>(state.range(0)));
    const std::filesystem::path path = tiles_path(source.frame().columns);
    if (!std::filesystem::exists(path)) return state.SkipWithError("run write_tiles first");
    const lod::TiledTerrain terrain(path, {.cache_bytes = static_cast<std::uint64_t>(state.range(1)) << 20});
    lod::View view(terrain, {.max_leaves = 200'000});
    lod::Camera camera;
    camera.eye = {5000, -100'000, terrain.lowest_highest()[1] + 300};
    camera.direction = {1, -0.3, -0.5};
    std::vector<double> times;
    double changes = 0, waiting = 0;
    for (auto _ : state) {
        const auto begin = std::chrono::steady_clock::now();
        const lod::Update update = view.update(camera, {.pixel_error = 0.5, .milliseconds = 4});
        times.push_back(milliseconds_since(begin));
        changes += update.splits + update.merges;
        waiting += update.waiting > 0;
        camera.eye += static_cast<double>(state.range(2)) * Vec3d(1, -0.3, 0);
        std::this_thread::sleep_until(begin + std::chrono::microseconds(16'667));
    }
    report_frames(state, times, changes);
    state.counters["waiting_frames"] = waiting;
    state.counters["loads"] = static_cast<double>(terrain.statistics().loads);
}
BENCHMARK(fly_tiles)->Args({16385, 64, 40})->Args({16385, 512, 40})->Iterations(3000)->Unit(benchmark::kMillisecond);

}  // namespace

}  // namespace tetrakis::bench
