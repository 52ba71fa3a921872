#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/surface.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../tests/kit/meshes.hpp"
#include "peers/quadtree_peers.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <span>
#include <utility>
#include <vector>

// Restricted quadtrees compared with those of p4est, on one thread and one rank.
namespace tetrakis::bench {

namespace {

// First benchmark, on a cube's surface: from its six faces to all leaves of a level, balanced across sides. Here a face
// is four corner cells, so level l of a face is level l - 1 of a cell.

constexpr int k_level = 9;  // of a face of the cube: 1.6 million squares

/// Refines round by round, as p4est does.
BisectionForest bisected(const ControlMesh& mesh) {
    BisectionForest forest(mesh);
    std::vector<LeafId> open, created;
    for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s) open.push_back(LeafId(s));
    for (int depth = 0; depth < 2 * (k_level - 1); ++depth) {
        forest.refine(open, created);
        std::swap(open, created);
    }
    return forest;
}

std::int64_t square_count(const BisectionForest& forest) {
    std::int64_t halves = 0;
    for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s)
        if (forest.is_leaf(LeafId(s))) halves += forest.depth(LeafId(s)) % 2 != 0 ? 1 : 2;
    return halves / 2;
}

void count(benchmark::State& state, std::int64_t squares) {
    state.SetItemsProcessed(state.iterations() * squares);
    state.counters["squares"] = static_cast<double>(squares);
}

void ours(benchmark::State& state) {
    const ControlMesh mesh = test::model("cube");
    RunContext context;
    context.threads = 1;
    std::int64_t squares = 0;
    double bytes = 0;
    with_threads(context, [&] {
        for (auto _ : state) {
            const BisectionForest forest = bisected(mesh);
            state.PauseTiming();
            squares = square_count(forest);
            bytes = static_cast<double>(forest.memory_bytes());
            state.ResumeTiming();
        }
    });
    count(state, squares);
    state.counters["bytes_per_square"] = bytes / static_cast<double>(squares);
}

#ifdef TETRAKIS_BENCH_P4EST
void p4est(benchmark::State& state, bool neighbours) {
    QuadtreeRun run;
    for (auto _ : state) {
        run = run_p4est(k_level, neighbours);
        state.SetIterationTime(run.seconds);
    }
    if (run.squares != square_count(bisected(test::model("cube"))))
        state.SkipWithError("p4est and BisectionForest have other squares");
    count(state, run.squares);
}

BENCHMARK_CAPTURE(p4est, leaves, false)->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK_CAPTURE(p4est, neighbours, true)->Unit(benchmark::kMillisecond)->UseManualTime();
#endif

BENCHMARK(ours)->Unit(benchmark::kMillisecond)->UseRealTime();

// Second benchmark: cost of a frame for a flat unit square whose leaves are as large as they are far from a moving
// target. Medians are of CPU time, because other work on the machine delays long frames more than short ones.

constexpr double k_height = 1e-4;  // of the eye above the target
// Length of a leaf's base relative to its distance: gives a million leaves. The p4est code has another constant.
constexpr double k_size = 0.0115;

class FlatSquare final : public lod::Surface {
  public:
    FlatSquare() {
        ControlMeshData data;
        data.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
        data.face_vertices = {0, 1, 2, 3};
        data.face_offsets = {0, 4};
        roots_ = ControlMesh::build(std::move(data));
    }
    const ControlMesh& roots() const override { return roots_; }
    /// Depth of leaves as large as a square of level k_finest_level: a root is a quarter of the unit square.
    int max_depth() const override { return 2 * k_finest_level - 2; }
    void places(std::span<const Site> sites, std::span<lod::Place> places) const override {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Vec3d at = position(sites[i]);
            places[i] = {.position = at, .normal = {0, 0, 1}, .uv = {at.x, at.y}, .on_edge = at};
        }
    }
    /// A diamond's error is the length of its base.
    void bounds(std::span<const Site> sites, std::span<lod::DiamondBounds> bounds) const override {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Site& site = sites[i];
            // The base is a diagonal of a square (midpoint at its centre), or a side. Each box contains the boxes of
            // the diamonds that a split makes possible: one step around a centre, half a step around a side.
            const bool is_centre = (site.at.x & site.at.y & 1u) != 0;
            const double step = side(site);
            const double reach = (is_centre ? 3 : 2) * step;
            bounds[i] = {position(site), {reach, reach, 0}, (is_centre ? 2 * M_SQRT2 : 2) * step};
        }
    }

  private:
    static double side(const Site& site) { return 0.5 / static_cast<double>(std::uint64_t{1} << site.level); }
    Vec3d position(const Site& site) const {
        // Corner cells are rotated by quarter turns around the square's centre.
        const double x = side(site) * site.at.x, y = side(site) * site.at.y;
        const std::array<Vec3d, 4> turned{{{x, y, 0}, {1 - y, x, 0}, {1 - x, 1 - y, 0}, {y, 1 - x, 0}}};
        return turned[site.root.value];
    }
    ControlMesh roots_;
};

double milliseconds(clockid_t clock) {
    timespec now{};
    clock_gettime(clock, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// @param move  adapts to the next target and returns the number of splits and merges
template <class Move>
double time_frames(benchmark::State& state, const Move& move) {
    // One round before timing: hysteresis delays merges, and p4est gains only one level in a frame.
    MovingTarget target{.step = 0.04};
    for (int i = 0; i < 40; ++i) move(target.next());
    target.step = 1e-6 * static_cast<double>(state.range(0));
    for (int i = 0; i < 10; ++i) move(target.next());
    std::vector<double> cpu, wall;
    double changes = 0;
    for (auto _ : state) {
        const TargetPoint at = target.next();
        const double cpu_begin = milliseconds(CLOCK_THREAD_CPUTIME_ID), begin = milliseconds(CLOCK_MONOTONIC);
        changes += static_cast<double>(move(at));
        cpu.push_back(milliseconds(CLOCK_THREAD_CPUTIME_ID) - cpu_begin);
        wall.push_back(milliseconds(CLOCK_MONOTONIC) - begin);
    }
    state.counters["cpu_ms"] = median(cpu);
    state.counters["wall_ms"] = median(wall);
    return changes / static_cast<double>(state.iterations());
}

double area(const TriangleMesh& mesh) {
    double twice = 0;
    for (const auto& t : mesh.triangles) {
        const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
        twice += glm::cross(b - a, c - a).z;
    }
    return twice / 2;
}

void moving_target(benchmark::State& state) {
    const FlatSquare square;
    lod::View view(square, {.max_leaves = 1'500'000, .outside_weight = 1});
    std::uint32_t leaves = 0;
    const double diamonds = time_frames(state, [&](const TargetPoint& at) {
        // With this field of view and 2 x 2 pixels, a pixel has length 1 at distance 1.
        const lod::Camera camera{.eye = {at.x, at.y, k_height}, .vertical_fov = M_PI / 2, .width = 2, .height = 2};
        const lod::Update update = view.update(camera, {.pixel_error = k_size});
        leaves = update.leaves;
        return update.splits + update.merges;
    });
    if (std::abs(area(view.mesh()) - 1) > 1e-9) state.SkipWithError("leaves do not tile the square");
    state.counters["leaves"] = leaves;
    state.counters["diamonds"] = diamonds;
    // A split replaces two leaves by four; a concurrent binary tree counts only the two additional leaves.
    state.counters["changed_leaves"] = 6 * diamonds;
    state.counters["changed_bits"] = 2 * diamonds;
}

// Argument: the target's step in millionths of the square's side. 3,410 leaves change with 184 here and with 283 in
// p4est. With 551, 3,410 bits change, the number that the baseline of libcbt counts.
#define TETRAKIS_BENCH_STEPS(name, frames) \
    BENCHMARK(name)->Arg(184)->Arg(283)->Arg(551)->Iterations(frames)->Unit(benchmark::kMillisecond)
TETRAKIS_BENCH_STEPS(moving_target, 300);

#ifdef TETRAKIS_BENCH_P4EST
void p4est_moving_target(benchmark::State& state) {
    const auto forest = make_p4est_target();
    const double families = time_frames(state, [&](const TargetPoint& at) { return forest->move(at); });
    if (!forest->is_balanced()) state.SkipWithError("p4est is not balanced");
    state.counters["leaves"] = static_cast<double>(forest->leaf_count());
    state.counters["families"] = families;
    state.counters["changed_leaves"] = 5 * families;  // a split replaces one leaf by four
}
TETRAKIS_BENCH_STEPS(p4est_moving_target, 25);
#endif

}  // namespace

}  // namespace tetrakis::bench
