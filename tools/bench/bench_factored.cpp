// Factored Catmull-Clark, two half-steps a level, against the direct structured refinement: one thread, kept buffers,
// points alone. Asked: at most twice the time.
#include "../../hier/base/parallel.hpp"
#include "../../refine/uniform/grid_refinement.hpp"
#include "piece_models.hpp"

#include <benchmark/benchmark.h>

namespace tetrakis::bench {

namespace {

template <class T, bool Factored>
void levels(benchmark::State& state) {
    const ControlMesh mesh = data_model("head");
    const std::vector<Vec3<T>> control(mesh.positions().begin(), mesh.positions().end());
    const detail::GridTopology topology(mesh, SchemeKind::catmull_clark, static_cast<int>(state.range(0)),
                                        detail::PointRule::scheme,
                                        Factored ? detail::RootPlace::corners : detail::RootPlace::faces);
    detail::GridPoints<T> steps(topology, Factored ? detail::LevelSteps::half : detail::LevelSteps::whole);
    RunContext context;
    context.threads = 1;
    with_threads(context, [&] {
        for (auto _ : state) {
            const T* points = steps.run(control, nullptr, context);
            benchmark::DoNotOptimize(points);
            benchmark::ClobberMemory();
        }
    });
    state.SetItemsProcessed(state.iterations() * topology.last().vertex_count());
}

#define TETRAKIS_BENCH(T, FACTORED, NAME) \
    BENCHMARK_TEMPLATE(levels, T, FACTORED)->Name(NAME)->ArgName("level")->Arg(3)->Arg(5)->Arg(6)

TETRAKIS_BENCH(double, false, "refine_factored/direct/head/double");
TETRAKIS_BENCH(double, true, "refine_factored/factored/head/double");
TETRAKIS_BENCH(float, false, "refine_factored/direct/head/float");
TETRAKIS_BENCH(float, true, "refine_factored/factored/head/float");

}  // namespace

}  // namespace tetrakis::bench
