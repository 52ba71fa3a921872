// Uniform refinement against OpenSubdiv, CGAL and OpenMesh in one run. The counter "vertex" is time per vertex of the
// last level; "share" is the share of the memory bandwidth that the triad of STREAM reaches here in the same run, for
// the bytes of the last level that must be written and those of the level above that must be read.
#include "bench_models.hpp"
#include "uniform_peers.hpp"

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../refine/uniform/uniform_refiner.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace tetrakis::bench {

namespace {

const ControlMesh& mesh_of(const BenchModel& model, SchemeKind scheme) {
    static std::map<std::pair<std::string_view, SchemeKind>, ControlMesh> cache;
    const auto [place, fresh] = cache.try_emplace({model.name, scheme});
    if (fresh) {
        place->second = ControlMesh::build(load_bench_model(model));
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

UniformOptions options_for(int threads, bool limit) {
    UniformOptions options;
    options.limit = limit;
    options.normals = limit;
    options.context.threads = threads;
    return options;
}

struct Case {
    const BenchModel* model;
    SchemeKind scheme;
    int levels, threads;
    bool limit;
};

/// The triad a = b + s c, in bytes a second; 24 bytes moved for 16 read and 8 written, as STREAM counts.
double triad_bandwidth(int threads) {
    static std::map<int, double> cache;
    if (const auto found = cache.find(threads); found != cache.end()) return found->second;
    constexpr std::uint32_t k_length = 16u << 20;
    std::vector<double> a(k_length, 1.0), b(k_length, 2.0), c(k_length, 3.0);
    double best = 0;
    RunContext context;
    context.threads = threads;
    with_threads(context, [&] {
        for (int i = 0; i < 9; ++i) {
            const auto start = std::chrono::steady_clock::now();
            for_each_block(k_length, 1u << 16, [&](std::uint32_t begin, std::uint32_t end) {
                for (std::uint32_t k = begin; k < end; ++k) a[k] = b[k] + 0.5 * c[k];
            });
            benchmark::DoNotOptimize(a.data());
            benchmark::ClobberMemory();
            const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
            best = std::max(best, 24.0 * k_length / time.count());
        }
    });
    return cache[threads] = best;
}

/// Times how much longer `whole` takes than `part`, each after a run of its own.
template <class Part, class Whole>
void add_time(benchmark::State& state, Part&& part, Whole&& whole) {
    const auto seconds = [](auto&& work) {
        work();
        const auto start = std::chrono::steady_clock::now();
        work();
        benchmark::ClobberMemory();
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    for (auto _ : state) {
        const double less = seconds(part), more = seconds(whole);
        state.SetIterationTime(std::max(more - less, 1e-9));
    }
}

/// From the control mesh in memory to an indexed level, in whatever memory the library has: what the last round freed,
/// as far as it keeps that.
template <class T>
void whole(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(*c.model, c.scheme);
    const std::vector<Vec3<T>> control(mesh.positions().begin(), mesh.positions().end());
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        UniformRefiner<T> refiner(mesh, c.scheme, c.levels, options_for(c.threads, c.limit));
        vertices = refiner.refine(control).positions.size();
        benchmark::ClobberMemory();
    }
    count(state, vertices);
}

/// The same in fresh memory.
template <class T>
void fresh(benchmark::State& state, Case c) {
    keep_freed_memory(0);
    whole<T>(state, c);
    keep_freed_memory(default_freed_memory());
}

/// The same in a caller's buffers that are kept: connectivity, positions and faces anew.
template <class T>
void reused(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(*c.model, c.scheme);
    const std::vector<Vec3<T>> control(mesh.positions().begin(), mesh.positions().end());
    std::vector<Vec3<T>> positions;
    std::vector<std::uint32_t> corners;
    const auto refine = [&] {
        UniformRefiner<T> refiner(mesh, c.scheme, c.levels, options_for(c.threads, c.limit));
        positions.resize(refiner.vertex_count());
        corners.resize(std::size_t{refiner.face_count()} * static_cast<std::size_t>(refiner.face_size()));
        refiner.refine(control, positions);
        refiner.faces(corners);
        benchmark::ClobberMemory();
    };
    refine();
    for (auto _ : state) refine();
    count(state, positions.size());
}

/// As `whole`, from flat arrays, i.e. with the control mesh's half-edges and checks.
void from_arrays(benchmark::State& state, Case c) {
    const ControlMeshData& data = mesh_of(*c.model, c.scheme).data();
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        RunContext context;
        context.threads = c.threads;
        const ControlMesh mesh = ControlMesh::build(data, context);
        UniformRefiner<double> refiner(mesh, c.scheme, c.levels, options_for(c.threads, c.limit));
        vertices = refiner.refine(mesh.positions()).positions.size();
        benchmark::ClobberMemory();
    }
    count(state, vertices);
}

/// Positions only, again, in buffers that are kept.
template <class T>
void again(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(*c.model, c.scheme);
    const std::vector<Vec3<T>> control(mesh.positions().begin(), mesh.positions().end());
    UniformRefiner<T> refiner(mesh, c.scheme, c.levels, options_for(c.threads, c.limit));
    const std::uint64_t vertices = refiner.vertex_count();
    refiner.refine(control);
    for (auto _ : state) {
        refiner.refine(control);
        benchmark::ClobberMemory();
    }
    count(state, vertices);
    const double bytes = static_cast<double>(vertices) * sizeof(Vec3<T>) * (c.limit ? 2 : 1.25);
    state.counters["share"] =
        benchmark::Counter(bytes / triad_bandwidth(c.threads), benchmark::Counter::kIsIterationInvariantRate);
}

/// The last level alone, from the one above, which has just been made: "share" is its own.
template <class T>
void last(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(*c.model, c.scheme);
    const std::vector<Vec3<T>> control(mesh.positions().begin(), mesh.positions().end());
    using Clock = std::chrono::steady_clock;
    std::optional<Clock::time_point> start;
    UniformOptions options = options_for(c.threads, c.limit);
    // Three quarters of all vertices are new in it.
    options.context.progress = [&](std::string_view, double fraction) {
        if (!start && fraction >= 0.25) start = Clock::now();
        return true;
    };
    UniformRefiner<T> refiner(mesh, c.scheme, c.levels, options);
    refiner.refine(control);
    for (auto _ : state) {
        start.reset();
        refiner.refine(control);
        benchmark::ClobberMemory();
        state.SetIterationTime(std::chrono::duration<double>(Clock::now() - start.value()).count());
    }
    count(state, refiner.vertex_count());
    const double bytes = static_cast<double>(refiner.vertex_count()) * sizeof(Vec3<T>) * 1.25;
    state.counters["share"] =
        benchmark::Counter(bytes / triad_bandwidth(c.threads), benchmark::Counter::kIsIterationInvariantRate);
}

/// The face indices, again, in a buffer that is kept.
void indices(benchmark::State& state, Case c) {
    UniformRefiner<float> refiner(mesh_of(*c.model, c.scheme), c.scheme, c.levels, options_for(c.threads, false));
    std::vector<std::uint32_t> corners(std::size_t{refiner.face_count()} *
                                       static_cast<std::size_t>(refiner.face_size()));
    for (auto _ : state) {
        refiner.faces(corners);
        benchmark::ClobberMemory();
    }
    count(state, refiner.vertex_count());
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
    enum class Part { fresh, again, last } part;
};

void by_rules(benchmark::State& state, RuleCase c) {
    const bool triangles = c.scheme->family == MeshFamily::triangles;
    const ControlMesh& mesh = mesh_of(*c.model, triangles ? SchemeKind::loop : SchemeKind::catmull_clark);
    RefineOptions options;
    options.context.threads = c.threads;
    const auto make = [&](int levels) {
        return with_threads(options.context, [&] { return RuleRefiner(mesh, *c.scheme, levels, options); });
    };
    std::vector<Vec3d> positions;
    RuleRefiner refiner = make(c.levels);
    const auto refine = [&] {
        positions.resize(refiner.vertex_count());
        refiner.refine(mesh.positions(), positions);
        benchmark::ClobberMemory();
    };
    if (c.part == RuleCase::Part::last) {
        RuleRefiner above = make(c.levels - 1);
        std::vector<Vec3d> coarser(above.vertex_count());
        add_time(
            state, [&] { above.refine(mesh.positions(), coarser); }, refine);
    } else {
        for (auto _ : state) {
            if (c.part == RuleCase::Part::fresh) refiner = make(c.levels);
            refine();
        }
    }
    count(state, positions.size());
    const double growth = c.scheme->refinement == Refinement::sqrt3 ? 9 : 4;
    const double bytes = static_cast<double>(positions.size()) * sizeof(Vec3d) * (1 + 1 / growth);
    state.counters["share"] =
        benchmark::Counter(bytes / triad_bandwidth(c.threads), benchmark::Counter::kIsIterationInvariantRate);
}

constexpr BenchModel k_dense{"spot-quads", "data/models/spot-quads.obj", SchemeKind::catmull_clark};

void add(const std::string& method, const Case& c, void (*run)(benchmark::State&, Case)) {
    std::string full(c.model->name);
    full += c.scheme == SchemeKind::loop ? "/loop/" : "/cc/";
    full += std::to_string(c.levels) + "/" + method + (c.limit ? "_limit" : "");
    if (c.threads == 2) full += "_2t";
    auto* const registered = benchmark::RegisterBenchmark(full.c_str(), run, c)->Unit(benchmark::kMillisecond);
    method.starts_with("last") ? registered->UseManualTime() : registered->UseRealTime();
}

void register_all() {
    const BenchModel* models[] = {find_bench_model("spot-control"), find_bench_model("suzanne"),
                                  find_bench_model("pawn"), &k_dense};
    for (const BenchModel* model : models)
        for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop})
            for (int levels = 3; levels <= 6; ++levels) {
                for (const bool limit : {false, true}) {
                    const Case one{model, scheme, levels, 1, limit}, two{model, scheme, levels, 2, limit};
                    add("fresh_double", one, fresh<double>);
                    add("fresh_float", one, fresh<float>);
                    add("whole_double", one, whole<double>);
                    add("whole_float", one, whole<float>);
                    add("again_double", one, again<double>);
                    add("again_float", one, again<float>);
                    add("again_double", two, again<double>);
                    add("again_float", two, again<float>);
                    if (!limit)
                        for (const Case& k : {one, two}) add("last_double", k, last<double>);
                    add("far_double", one, far<double>);
                    add("far_float", one, far<float>);
                }
                const Case c{model, scheme, levels, 1, false};
                add("fresh_double", {model, scheme, levels, 2, false}, fresh<double>);
                add("reused_double", c, reused<double>);
                add("reused_float", c, reused<float>);
                add("from_arrays", c, from_arrays);
                add("indices", c, indices);
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
            add("fresh_double", c, fresh<double>);
            add("reused_double", c, reused<double>);
            add("again_double", c, again<double>);
        }
}

/// Without texture coordinates, which peers leave alone.
ControlMesh bare_mesh_of(const RuleCase& c) {
    const bool triangles = c.scheme->family == MeshFamily::triangles;
    ControlMeshData data = mesh_of(*c.model, triangles ? SchemeKind::loop : SchemeKind::catmull_clark).data();
    data.uvs.clear();
    data.face_uvs.clear();
    data.uv_lines.clear();
    return ControlMesh::build(std::move(data));
}

/// refine(): from the control mesh to a mesh of the last level, by whatever way is the fastest.
template <bool WithLimit>
void whole_mesh(benchmark::State& state, RuleCase c) {
    const ControlMesh mesh = bare_mesh_of(c);
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
void positions_again(benchmark::State& state, RuleCase c) {
    const ControlMesh mesh = bare_mesh_of(c);
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
    if (WithLimit) return;
    const double growth = c.scheme->refinement == Refinement::sqrt3 ? 9 : 4;
    const double bytes = static_cast<double>(positions.size()) * sizeof(Vec3d) * (1 + 1 / growth);
    state.counters["share"] =
        benchmark::Counter(bytes / triad_bandwidth(c.threads), benchmark::Counter::kIsIterationInvariantRate);
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
                const RuleCase c{&smooth, &scheme, scheme.refinement == Refinement::sqrt3 ? 4 : 5, threads,
                                 RuleCase::Part::fresh};
                for (const auto& [method, run] :
                     {std::pair("refine", &whole_mesh<false>), std::pair("refine_limit", &whole_mesh<true>),
                      std::pair("again", &positions_again<false>), std::pair("again_limit", &positions_again<true>)}) {
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
        for (const auto& [part, method] :
             {std::pair(RuleCase::Part::fresh, "fresh"), std::pair(RuleCase::Part::again, "again"),
              std::pair(RuleCase::Part::last, "last")})
            for (const int threads : {1, 2}) {
                // About 200 000 points each.
                const int levels = scheme.refinement == Refinement::sqrt3 ? 3 : 4;
                const RuleCase c{model, &scheme, levels, threads, part};
                const std::string full = fmt::format("{}/{}/{}/rules_{}{}", model->name, scheme.name, levels, method,
                                                     threads == 2 ? "_2t" : "");
                auto* const registered =
                    benchmark::RegisterBenchmark(full.c_str(), by_rules, c)->Unit(benchmark::kMillisecond);
                part == RuleCase::Part::last ? registered->UseManualTime() : registered->UseRealTime();
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
