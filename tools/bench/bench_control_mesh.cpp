#include "piece_models.hpp"

#include <benchmark/benchmark.h>

namespace tetrakis::bench {

namespace {

// Half-edges and checks of a million quads (1000 x 1000) should take well under a second.
void build(benchmark::State& state) {
    const ControlMeshData data = torus(static_cast<std::uint32_t>(state.range(0)));
    RunContext context;
    context.threads = static_cast<int>(state.range(1));
    std::uint32_t edges = 0;
    for (auto _ : state) {
        state.PauseTiming();
        ControlMeshData copy = data;
        state.ResumeTiming();
        const ControlMesh mesh = ControlMesh::build(std::move(copy), context);
        edges = mesh.edge_count();
    }
    if (edges != 2 * data.positions.size()) state.SkipWithError("a torus of n quads has 2 n edges");
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(data.face_offsets.size() - 1));
}

void read(benchmark::State& state, const char* name) {
    for (auto _ : state) benchmark::DoNotOptimize(data_model(name));
}

}  // namespace

BENCHMARK(build)
    ->Name("control_mesh/build/torus")
    ->ArgsProduct({{100, 1000}, {1, 2}})
    ->ArgNames({"side", "threads"})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(read, head, "head")->Name("control_mesh/read/head")->Unit(benchmark::kMillisecond);

}  // namespace tetrakis::bench
