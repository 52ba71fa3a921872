#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "peers/quadtree_peers.hpp"

#include <benchmark/benchmark.h>

#include <cstdint>
#include <utility>
#include <vector>

// Restricted quadtrees on a cube's surface: from the six faces to all leaves of a level, balanced across sides, as in
// p4est. A face is four corner cells of ours, so level l of a face is our level l - 1. One thread, one rank.
namespace tetrakis::bench {

namespace {

ControlMesh cube() {
    ControlMeshData data;
    for (int v = 0; v < 8; ++v) data.positions.emplace_back(v & 1, v >> 1 & 1, v >> 2);
    data.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    for (std::uint32_t f = 0; f <= 6; ++f) data.face_offsets.push_back(4 * f);
    return ControlMesh::build(std::move(data));
}

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
    const ControlMesh mesh = cube();
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
    if (run.squares != square_count(bisected(cube())))
        state.SkipWithError("p4est and BisectionForest have other squares");
    count(state, run.squares);
}

BENCHMARK_CAPTURE(p4est, leaves, false)->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK_CAPTURE(p4est, neighbours, true)->Unit(benchmark::kMillisecond)->UseManualTime();
#endif

}  // namespace

BENCHMARK(ours)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace tetrakis::bench
