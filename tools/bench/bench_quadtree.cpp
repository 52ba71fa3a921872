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

// Restricted quadtrees beside those of p4est. One thread, one rank.
namespace tetrakis::bench {

namespace {

// On a cube's surface: from the six faces to all leaves of a level, balanced across sides. A face is four corner cells
// of ours, so level l of a face is our level l - 1.

constexpr int k_level = 9;  // of a face of the cube: 1.6 million squares

/// Round by round, as p4est does it.
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

// A flat unit square with leaves as large as they are far from a target that moves: what one frame costs. Medians are
// of CPU time, because other work on the machine stretches long frames more than short ones.

constexpr double k_height = 1e-4;  // of the eye above the target
// Lengths of bases, by distance: a million leaves. p4est has a constant of its own, for as many.
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
    /// The area of a square of level k_finest_level, as roots have a quarter of the unit square.
    int max_depth() const override { return 2 * k_finest_level - 2; }
    void places(std::span<const Site> sites, std::span<lod::Place> places) const override {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Vec3d at = position(sites[i]);
            places[i] = {.position = at, .normal = {0, 0, 1}, .uv = {at.x, at.y}, .on_edge = at};
        }
    }
    /// Errors are lengths of bases.
    void bounds(std::span<const Site> sites, std::span<lod::DiamondBounds> bounds) const override {
        for (std::size_t i = 0; i < sites.size(); ++i) {
            const Site& site = sites[i];
            // The base is a diagonal of squares around their centre, or two sides. Boxes hold the boxes of the diamonds
            // that a split makes possible: around a centre one step away, around sides half a step.
            const bool is_centre = (site.at.x & site.at.y & 1u) != 0;
            const double step = side(site);
            const double reach = (is_centre ? 3 : 2) * step;
            bounds[i] = {position(site), {reach, reach, 0}, (is_centre ? 2 * M_SQRT2 : 2) * step};
        }
    }

  private:
    static double side(const Site& site) { return 0.5 / static_cast<double>(std::uint64_t{1} << site.level); }
    Vec3d position(const Site& site) const {
        // Corner cells are turned by quarters around the square's centre.
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

/// @param move  goes to the next target and says how many splits and merges that took
template <class Move>
double time_frames(benchmark::State& state, const Move& move) {
    // Once around, because merges come later than splits by hysteresis; p4est gains one level in a frame.
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
        // A picture of 2 x 2 pixels with this opening has pixels of length 1 at distance 1.
        const lod::Camera camera{.eye = {at.x, at.y, k_height}, .vertical_fov = M_PI / 2, .width = 2, .height = 2};
        const lod::Update update = view.update(camera, {.pixel_error = k_size});
        leaves = update.leaves;
        return update.splits + update.merges;
    });
    if (std::abs(area(view.mesh()) - 1) > 1e-9) state.SkipWithError("leaves do not tile the square");
    state.counters["leaves"] = leaves;
    state.counters["diamonds"] = diamonds;
    // A split replaces two leaves by four; a concurrent binary tree counts the two more alone.
    state.counters["changed_leaves"] = 6 * diamonds;
    state.counters["changed_bits"] = 2 * diamonds;
}

// Millionths of the square's side in a frame. 3,410 leaves come or go with 184 here and with 283 in p4est; with 551
// there are 3,410 changed bits, which is what the baseline counts of libcbt.
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
    state.counters["changed_leaves"] = 5 * families;  // a split replaces one by four
}
TETRAKIS_BENCH_STEPS(p4est_moving_target, 25);
#endif

}  // namespace

}  // namespace tetrakis::bench
