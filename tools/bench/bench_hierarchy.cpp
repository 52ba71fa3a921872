#include "../../eval/patches/limit_surface.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../tests/kit/meshes.hpp"

#include <benchmark/benchmark.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

// Cost of operations, vertices and leaves of hierarchies. One operation splits or merges one diamond: it changes the
// diamond's leaves, their neighbours and the midpoint.
namespace tetrakis::bench {

namespace {

RunContext context_of(std::int64_t threads) {
    RunContext context;
    context.threads = static_cast<int>(threads);
    return context;
}

void all_leaves(const BisectionForest& forest, std::vector<LeafId>& leaves) {
    leaves.clear();
    for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s)
        if (forest.is_leaf(LeafId(s))) leaves.push_back(LeafId(s));
}

// Splits all leaves, round by round, then merges everything again.
void forest_operations(benchmark::State& state, bool single) {
    const ControlMesh mesh = ControlMesh::build(test::grid(32, false, true));
    BisectionForest forest(mesh);
    std::vector<LeafId> leaves, created;
    std::int64_t operations = 0;
    const auto ignore = [](const Diamond&) {};
    if (single) forest.reserve(forest.leaf_count() << state.range(0));
    with_threads(context_of(1), [&] {
        for (auto _ : state) {
            all_leaves(forest, leaves);  // later, the leaves that a round creates are all leaves
            for (std::int64_t round = 0; round < state.range(0); ++round) {
                if (single) {
                    for (LeafId leaf : leaves)
                        if (forest.depth(leaf) == round) forest.split_diamond(leaf, ignore);
                    all_leaves(forest, leaves);
                    continue;
                }
                forest.refine(leaves, created);
                std::swap(leaves, created);
            }
            operations += 2 * std::int64_t{forest.midpoint_count()};
            while (forest.midpoint_count() > 0) {
                if (single) {
                    for (LeafId leaf : leaves)
                        if (forest.is_leaf(leaf)) forest.merge_diamond(leaf, ignore);
                    all_leaves(forest, leaves);
                    continue;
                }
                forest.coarsen(leaves, created);
                std::swap(leaves, created);
            }
        }
    });
    state.SetItemsProcessed(operations);
}

// Refines all leaves to a uniform level and makes the mesh with limit positions. `bytes` count the hierarchy itself.
void to_uniform_level(benchmark::State& state, const std::string& scheme, const std::string& model, bool by_patches) {
    const bool triangles = scheme == "loop", sqrt3 = scheme == "sqrt3";
    const ControlMesh mesh = sqrt3 ? triangulate(test::model(model)) : test::model(model);
    const int level = static_cast<int>(state.range(0));
    HierarchyOptions options;
    options.context = context_of(state.range(1));
    if (by_patches) options.limit_positions = std::make_shared<LimitSurface>(mesh, scheme_from_name(scheme).value());
    // Bisection: depth 2 l + 1 has all points of lattice level l, which is scheme level l + 1. sqrt3: four a level.
    const bool bisection = make_hierarchy(mesh, scheme, options).family() == "bisection";
    const int depth = bisection ? 2 * level - 1 : sqrt3 ? 4 * level : triangles ? level : level - 1;
    std::int64_t vertices = 0;
    for (auto _ : state) {
        Hierarchy h = make_hierarchy(mesh, scheme, options);
        h.refine_where(each_leaf([](const LeafView&) { return true; }), depth, options.context);
        const HierarchyMesh out = h.to_mesh({.context = options.context});
        vertices += static_cast<std::int64_t>(out.sites.size());
        state.counters["bytes_per_leaf"] = static_cast<double>(h.memory_bytes()) / h.leaf_count();
    }
    state.SetItemsProcessed(vertices);
    state.counters["vertices"] = static_cast<double>(vertices) / static_cast<double>(state.iterations());
}

}  // namespace

BENCHMARK_CAPTURE(forest_operations, bulk, false)
    ->Name("hierarchy/forest_operations/bulk")
    ->Arg(4)
    ->Arg(8)
    ->ArgName("rounds");
BENCHMARK_CAPTURE(forest_operations, single, true)
    ->Name("hierarchy/forest_operations/single")
    ->Arg(6)
    ->ArgName("rounds");

#define TETRAKIS_BENCH_TO_LEVEL(name, scheme, model, patches)         \
    BENCHMARK_CAPTURE(to_uniform_level, name, scheme, model, patches) \
        ->Name("hierarchy/to_uniform_level/" #name)                   \
        ->ArgsProduct({{5}, {1, 2}})                                  \
        ->ArgNames({"level", "threads"})                              \
        ->Unit(benchmark::kMillisecond)                               \
        ->UseRealTime()
TETRAKIS_BENCH_TO_LEVEL(catmull_clark_patches, "catmull-clark", "pawn", true);
TETRAKIS_BENCH_TO_LEVEL(catmull_clark_rows, "catmull-clark", "pawn", false);
TETRAKIS_BENCH_TO_LEVEL(loop_patches, "loop", "knot_tri", true);
TETRAKIS_BENCH_TO_LEVEL(loop_rows, "loop", "knot_tri", false);
TETRAKIS_BENCH_TO_LEVEL(kobbelt_rules, "kobbelt", "cube", false);
TETRAKIS_BENCH_TO_LEVEL(doo_sabin_rules, "doo-sabin", "knot", false);
TETRAKIS_BENCH_TO_LEVEL(sqrt3_hierarchy, "sqrt3", "cube", false);
TETRAKIS_BENCH_TO_LEVEL(sqrt3_hierarchy_creases, "sqrt3", "extruded_pentagon", false);

}  // namespace tetrakis::bench
