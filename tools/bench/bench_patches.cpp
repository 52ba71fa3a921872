#include "../../eval/loop_patches/loop_patches.hpp"
#include "../../eval/patches/quad_patches.hpp"
#include "piece_models.hpp"

#include <benchmark/benchmark.h>

#include <type_traits>

namespace tetrakis::bench {

namespace {

constexpr int k_level = 4;  // 17 x 17 points a cell, its borders and extraordinary corners among them
constexpr std::uint32_t k_side = 1u << k_level;

template <class Patches>
void construct(benchmark::State& state, const char* name) {
    const ControlMesh mesh = data_model(name);
    for (auto _ : state) {
        const Patches patches(mesh);
        benchmark::DoNotOptimize(&patches);
    }
    state.SetItemsProcessed(state.iterations() * mesh.halfedge_count());
}

/// Calls point(root, x, y) for the lattice points of every root.
template <class Point>
std::int64_t for_each_point(const ControlMesh& mesh, bool triangles, const Point& point) {
    std::int64_t count = 0;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); h += triangles ? 3 : 1)
        for (std::uint32_t y = 0; y <= k_side; ++y)
            for (std::uint32_t x = 0; x <= (triangles ? k_side - y : k_side); ++x, ++count) point(HalfedgeId(h), x, y);
    return count;
}

/// Times evaluate(patches, root, x, y) at all of them.
template <class Patches, class Evaluate>
void time_points(benchmark::State& state, const char* name, const Evaluate& evaluate) {
    const ControlMesh mesh = data_model(name);
    const Patches patches(mesh);
    std::int64_t count = 0;
    for (auto _ : state)
        count = for_each_point(mesh, std::is_same_v<Patches, LoopPatches>,
                               [&](HalfedgeId root, std::uint32_t x, std::uint32_t y) {
                                   benchmark::DoNotOptimize(evaluate(patches, root, x, y));
                               });
    state.SetItemsProcessed(state.iterations() * count);
}

template <class Patches>
void limit(benchmark::State& state, const char* name) {
    time_points<Patches>(state, name, [](const Patches& patches, HalfedgeId root, std::uint32_t x, std::uint32_t y) {
        return patches.limit(root, LatticePoint{x, y}, k_level);
    });
}

template <class Patches>
void evaluate(benchmark::State& state, const char* name) {
    time_points<Patches>(state, name, [](const Patches& patches, HalfedgeId root, std::uint32_t x, std::uint32_t y) {
        return patches.evaluate(root, static_cast<double>(x) / k_side, static_cast<double>(y) / k_side);
    });
}

// The macros take functions, no instances of templates with arguments.
constexpr auto construct_quads = &construct<QuadPatches>;
constexpr auto construct_triangles = &construct<LoopPatches>;
constexpr auto limit_quads = &limit<QuadPatches>;
constexpr auto limit_triangles = &limit<LoopPatches>;
constexpr auto evaluate_quads = &evaluate<QuadPatches>;
constexpr auto evaluate_triangles = &evaluate<LoopPatches>;

}  // namespace

BENCHMARK_CAPTURE(construct_quads, head, "head")->Name("patches/construct/catmull_clark/head");
BENCHMARK_CAPTURE(construct_quads, rook, "rook")->Name("patches/construct/catmull_clark/rook");
BENCHMARK_CAPTURE(construct_triangles, knot_tri, "knot_tri")->Name("patches/construct/loop/knot_tri");
BENCHMARK_CAPTURE(construct_triangles, bracket_tri, "bracket_tri")->Name("patches/construct/loop/bracket_tri");
BENCHMARK_CAPTURE(limit_quads, head, "head")->Name("patches/limit/catmull_clark/head");
BENCHMARK_CAPTURE(limit_quads, rook, "rook")->Name("patches/limit/catmull_clark/rook");
BENCHMARK_CAPTURE(limit_triangles, knot_tri, "knot_tri")->Name("patches/limit/loop/knot_tri");
BENCHMARK_CAPTURE(limit_triangles, bracket_tri, "bracket_tri")->Name("patches/limit/loop/bracket_tri");
BENCHMARK_CAPTURE(evaluate_quads, head, "head")->Name("patches/evaluate/catmull_clark/head");
BENCHMARK_CAPTURE(evaluate_quads, rook, "rook")->Name("patches/evaluate/catmull_clark/rook");
BENCHMARK_CAPTURE(evaluate_triangles, knot_tri, "knot_tri")->Name("patches/evaluate/loop/knot_tri");
BENCHMARK_CAPTURE(evaluate_triangles, bracket_tri, "bracket_tri")->Name("patches/evaluate/loop/bracket_tri");

}  // namespace tetrakis::bench
