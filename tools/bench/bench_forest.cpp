#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "piece_models.hpp"

#include <benchmark/benchmark.h>

namespace tetrakis::bench {

namespace {

// Splits all leaves, round after round.
BisectionForest grown(const ControlMesh& mesh, int rounds) {
    BisectionForest forest(mesh);
    std::vector<LeafId> marked, created;
    for (int round = 0; round < rounds; ++round) {
        marked.clear();
        for (std::uint32_t slot = 0; slot < forest.leaf_slots(); ++slot)
            if (forest.is_leaf(LeafId(slot))) marked.push_back(LeafId(slot));
        forest.refine(marked, created);
    }
    return forest;
}

RunContext with(std::int64_t threads) {
    RunContext context;
    context.threads = static_cast<int>(threads);
    return context;
}

void refine(benchmark::State& state) {
    const ControlMesh mesh = data_model("head");
    std::uint32_t leaves = 0;
    for (auto _ : state)
        with_threads(with(state.range(1)),
                     [&] { leaves = grown(mesh, static_cast<int>(state.range(0))).leaf_count(); });
    if (leaves != mesh.halfedge_count() << state.range(0)) state.SkipWithError("a round doubles the leaves");
    state.counters["bytes_per_leaf"] =
        static_cast<double>(grown(mesh, static_cast<int>(state.range(0))).memory_bytes()) / leaves;
    state.SetItemsProcessed(state.iterations() * leaves);
}

void export_all(benchmark::State& state) {
    const ControlMesh mesh = data_model("head");
    const BisectionForest forest = grown(mesh, static_cast<int>(state.range(0)));
    for (auto _ : state) with_threads(with(state.range(1)), [&] { benchmark::DoNotOptimize(forest.exported()); });
    state.SetItemsProcessed(state.iterations() * forest.leaf_count());
}

}  // namespace

BENCHMARK(refine)
    ->Name("forest/refine/head")
    ->ArgsProduct({{8}, {1, 2}})
    ->ArgNames({"rounds", "threads"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK(export_all)
    ->Name("forest/export/head")
    ->ArgsProduct({{8}, {1, 2}})
    ->ArgNames({"rounds", "threads"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

}  // namespace tetrakis::bench
