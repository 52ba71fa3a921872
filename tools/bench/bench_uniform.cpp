// Uniform refinement against OpenSubdiv, CGAL and OpenMesh in one run. The counter "vertex" is time per vertex of the
// last level.
#include "bench_models.hpp"
#include "peers/uniform_peers.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace tetrakis::bench {

namespace {

const ControlMesh& mesh_of(const BenchModel& model, SchemeKind scheme) {
    static std::map<std::pair<std::string_view, SchemeKind>, ControlMesh> cache;
    const auto [place, fresh] = cache.try_emplace({model.name, scheme});
    if (fresh) {
        ControlMeshData data = load_bench_model(model);
        // Peers leave texture coordinates alone.
        data.uvs.clear();
        data.face_uvs.clear();
        data.uv_lines.clear();
        place->second = ControlMesh::build(std::move(data));
        if (scheme == SchemeKind::loop) place->second = triangulate(place->second);
    }
    return place->second;
}

void count(benchmark::State& state, std::uint64_t vertices) {
    using benchmark::Counter;
    state.counters["vertices"] = static_cast<double>(vertices);
    state.counters["vertex"] =
        Counter(static_cast<double>(vertices), Counter::kIsIterationInvariantRate | Counter::kInvert);
}

RefineOptions options_for(int threads, bool limit) {
    RefineOptions options;
    options.limit = options.normals = limit;
    options.context.threads = threads;
    return options;
}

struct Case {
    const BenchModel* model;
    SchemeKind scheme;
    int levels, threads;
    bool limit;
};

/// From the control mesh in memory to a mesh of the last level, in whatever memory the library has: what the last round
/// freed, as far as it keeps that.
void full_refinement(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(*c.model, c.scheme);
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        vertices = refine(mesh, name(c.scheme), c.levels, options_for(c.threads, c.limit)).positions.size();
        benchmark::ClobberMemory();
    }
    count(state, vertices);
}

/// The same in fresh memory.
void full_cold_refinement(benchmark::State& state, Case c) {
    keep_freed_memory(0);
    full_refinement(state, c);
    keep_freed_memory(default_freed_memory());
}

/// As `full_refinement`, from flat arrays, i.e. with the control mesh's half-edges and checks.
void from_arrays(benchmark::State& state, Case c) {
    const ControlMeshData& data = mesh_of(*c.model, c.scheme).data();
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        const RefineOptions options = options_for(c.threads, c.limit);
        const ControlMesh mesh = ControlMesh::build(data, options.context);
        vertices = refine(mesh, name(c.scheme), c.levels, options).positions.size();
        benchmark::ClobberMemory();
    }
    count(state, vertices);
}

/// Positions only, again, in buffers that are kept.
void positions_refinement(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(*c.model, c.scheme);
    const PositionRefiner refiner(mesh, name(c.scheme), c.levels, options_for(c.threads, c.limit));
    std::vector<Vec3d> positions(refiner.mesh().positions.size()), normals(refiner.mesh().normals.size());
    for (auto _ : state) {
        refiner.refine(mesh.positions(), positions, normals);
        benchmark::ClobberMemory();
    }
    count(state, positions.size());
}

template <class T>
void far(benchmark::State& state, Case c) {
    const ControlMeshData& data = mesh_of(*c.model, c.scheme).data();
    std::uint64_t vertices = 0;
    for (auto _ : state) vertices = far_uniform<T>({data, c.scheme, c.levels, c.limit});
    count(state, vertices);
}

void stencils(benchmark::State& state, Case c) {
    const auto evaluate = stencil_evaluation({mesh_of(*c.model, c.scheme).data(), c.scheme, c.levels});
    std::uint64_t vertices = 0;
    for (auto _ : state) vertices = evaluate();
    count(state, vertices);
}

template <class Make>
void in_place(benchmark::State& state, Case c, Make make, std::string_view name = {}) {
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        state.PauseTiming();
        auto refine = make(UniformTask{mesh_of(*c.model, c.scheme).data(), c.scheme, c.levels, false, name});
        if (!refine) {
            state.SkipWithError("the peer does not take this mesh");
            break;
        }
        state.ResumeTiming();
        vertices = refine();
        state.PauseTiming();
        refine = nullptr;
        state.ResumeTiming();
    }
    if (vertices != 0) count(state, vertices);
}

/// Any scheme by its rules: from the control mesh to the last level, or positions only, again.
struct RuleCase {
    const BenchModel* model;
    const SchemeInfo* scheme;
    int levels, threads;
    bool positions_only = false;
};

const ControlMesh& mesh_of(const RuleCase& c) {
    return mesh_of(*c.model, c.scheme->family == MeshFamily::triangles ? SchemeKind::loop : SchemeKind::catmull_clark);
}

void by_rules(benchmark::State& state, RuleCase c) {
    const ControlMesh& mesh = mesh_of(c);
    RefineOptions options;
    options.context.threads = c.threads;
    const auto make = [&] {
        return with_threads(options.context, [&] { return RuleRefiner(mesh, *c.scheme, c.levels, options); });
    };
    RuleRefiner refiner = make();
    std::vector<Vec3d> positions(refiner.vertex_count());
    for (auto _ : state) {
        if (!c.positions_only) refiner = make();
        refiner.refine(mesh.positions(), positions);
        benchmark::ClobberMemory();
    }
    count(state, positions.size());
}

constexpr BenchModel k_dense{"spot-quads", "data/models/spot-quads.obj", SchemeKind::catmull_clark};

void add(const std::string& method, const Case& c, void (*run)(benchmark::State&, Case)) {
    std::string full(c.model->name);
    full += c.scheme == SchemeKind::loop ? "/loop/" : "/cc/";
    full += std::to_string(c.levels) + "/" + method + (c.limit ? "_limit" : "");
    if (c.threads == 2) full += "_2t";
    benchmark::RegisterBenchmark(full.c_str(), run, c)->Unit(benchmark::kMillisecond)->UseRealTime();
}

void register_all() {
    const BenchModel* models[] = {find_bench_model("spot-control"), find_bench_model("suzanne"),
                                  find_bench_model("pawn"), &k_dense};
    for (const BenchModel* model : models)
        for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop})
            for (int levels = 3; levels <= 6; ++levels) {
                for (const bool limit : {false, true}) {
                    const Case one{model, scheme, levels, 1, limit}, two{model, scheme, levels, 2, limit};
                    add("full_cold", one, full_cold_refinement);
                    add("full", one, full_refinement);
                    add("positions", one, positions_refinement);
                    add("positions", two, positions_refinement);
                    add("far_double", one, far<double>);
                    add("far_float", one, far<float>);
                }
                const Case c{model, scheme, levels, 1, false};
                add("full_cold", {model, scheme, levels, 2, false}, full_cold_refinement);
                add("from_arrays", c, from_arrays);
                add("stencils", c, stencils);
#ifdef TETRAKIS_BENCH_CGAL
                add("cgal", c, [](benchmark::State& state, Case k) { in_place(state, k, cgal_uniform); });
#endif
#ifdef TETRAKIS_BENCH_OPENMESH
                add("openmesh", c, [](benchmark::State& state, Case k) { in_place(state, k, openmesh_uniform); });
#endif
            }
}

/// How the time of a vertex grows from 8 to 129 million of them, 6 GB, with two threads.
void register_large() {
    for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop})
        for (const int levels : {7, 9}) {
            const Case c{find_bench_model("suzanne"), scheme, levels, 2, false};
            add("full_cold", c, full_cold_refinement);
            add("positions", c, positions_refinement);
        }
}

/// refine(): from the control mesh to a mesh of the last level, by whatever way is the fastest.
template <bool WithLimit>
void full_mesh(benchmark::State& state, RuleCase c) {
    const ControlMesh& mesh = mesh_of(c);
    RefineOptions options;
    options.limit = options.normals = WithLimit;
    options.context.threads = c.threads;
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        const PolygonMesh last = refine(mesh, *c.scheme, c.levels, options);
        vertices = last.positions.size();
        benchmark::ClobberMemory();
    }
    count(state, vertices);
}

/// Positions only, again, in a buffer that is kept, by the way that refine() takes.
template <bool WithLimit>
void positions_of_scheme(benchmark::State& state, RuleCase c) {
    const ControlMesh& mesh = mesh_of(c);
    RefineOptions options;
    options.limit = options.normals = WithLimit;
    options.context.threads = c.threads;
    const PositionRefiner refiner(mesh, *c.scheme, c.levels, options);
    std::vector<Vec3d> positions(refiner.mesh().positions.size()), normals(refiner.mesh().normals.size());
    for (auto _ : state) {
        refiner.refine(mesh.positions(), positions, normals);
        benchmark::ClobberMemory();
    }
    count(state, positions.size());
}

/// What peers have besides Catmull-Clark and Loop.
template <class Make>
void add_peer(const BenchModel& model, const SchemeInfo& scheme, int levels, const char* peer, Make make) {
    // A level of ours is two of the peers' steps of sqrt3.
    const Case c{&model, scheme.family == MeshFamily::triangles ? SchemeKind::loop : SchemeKind::catmull_clark,
                 scheme.refinement == Refinement::sqrt3 ? 2 * levels : levels, 1, false};
    const std::string full = fmt::format("{}/{}/{}/{}", model.name, scheme.name, levels, peer);
    benchmark::RegisterBenchmark(full.c_str(),
                                 [=, name = scheme.name](benchmark::State& state) { in_place(state, c, make, name); })
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
}

void register_schemes() {
    for (const char* name : {"spot-control", "suzanne"}) {
        const BenchModel& smooth = *find_bench_model(name);
        for (const SchemeInfo& scheme : scheme_table())
            for (const int threads : {1, 2}) {
                const RuleCase c{&smooth, &scheme, scheme.refinement == Refinement::sqrt3 ? 4 : 5, threads};
                for (const auto& [method, run] :
                     {std::pair("refine", &full_mesh<false>), std::pair("refine_limit", &full_mesh<true>),
                      std::pair("positions", &positions_of_scheme<false>),
                      std::pair("positions_limit", &positions_of_scheme<true>)}) {
                    const std::string full =
                        fmt::format("{}/{}/{}/{}{}", name, scheme.name, c.levels, method, threads == 2 ? "_2t" : "");
                    benchmark::RegisterBenchmark(full.c_str(), run, c)->Unit(benchmark::kMillisecond)->UseRealTime();
                }
            }
#ifdef TETRAKIS_BENCH_CGAL
        add_peer(smooth, *find_scheme("doo-sabin"), 5, "cgal", cgal_uniform);
        add_peer(smooth, *find_scheme("sqrt3"), 4, "cgal", cgal_uniform);
#endif
#ifdef TETRAKIS_BENCH_OPENMESH
        add_peer(smooth, *find_scheme("modified-butterfly"), 5, "openmesh", openmesh_uniform);
        add_peer(smooth, *find_scheme("sqrt3"), 4, "openmesh", openmesh_uniform);
#endif
    }
    const BenchModel* model = find_bench_model("pawn");
    for (const SchemeInfo& scheme : scheme_table())
        for (const bool positions_only : {false, true})
            for (const int threads : {1, 2}) {
                // About 200 000 points each.
                const int levels = scheme.refinement == Refinement::sqrt3 ? 3 : 4;
                const RuleCase c{model, &scheme, levels, threads, positions_only};
                const std::string full = fmt::format("{}/{}/{}/rules_{}{}", model->name, scheme.name, levels,
                                                     positions_only ? "positions" : "full", threads == 2 ? "_2t" : "");
                benchmark::RegisterBenchmark(full.c_str(), by_rules, c)->Unit(benchmark::kMillisecond)->UseRealTime();
            }
}

}  // namespace

}  // namespace tetrakis::bench

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    tetrakis::bench::register_all();
    tetrakis::bench::register_large();
    tetrakis::bench::register_schemes();
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
