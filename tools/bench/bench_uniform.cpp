// Uniform refinement against OpenSubdiv, CGAL and OpenMesh in one run. The counter "vertex" is time per vertex of the
// last level.
#include "bench_models.hpp"
#include "peers/uniform_peers.hpp"

#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::bench {

namespace {

/// A model, and how it is refined.
struct Case {
    const BenchModel* model;
    const SchemeInfo* scheme;
    int levels, threads;
    bool limit = false;

    bool triangles() const { return scheme->family == MeshFamily::triangles; }
    RefineOptions options() const {
        RefineOptions options;
        options.limit = options.normals = limit;
        options.context.threads = threads;
        return options;
    }
};

const ControlMesh& mesh_of(const Case& c) {
    static std::map<std::pair<std::string_view, bool>, ControlMesh> cache;
    const auto [place, fresh] = cache.try_emplace({c.model->name, c.triangles()});
    if (fresh) {
        ControlMeshData data = load_bench_model(*c.model);
        // Peers leave texture coordinates alone.
        data.uvs.clear();
        data.face_uvs.clear();
        data.uv_lines.clear();
        place->second = ControlMesh::build(std::move(data));
        if (c.triangles()) place->second = triangulate(place->second);
    }
    return place->second;
}

/// For a peer. @param name  of a scheme that is none of the usual two
UniformTask task_of(const Case& c, std::string_view name = {}) {
    // A level of ours is two of the peers' steps of sqrt3.
    return {mesh_of(c).data(), c.triangles() ? SchemeKind::loop : SchemeKind::catmull_clark,
            c.scheme->refinement == Refinement::sqrt3 ? 2 * c.levels : c.levels, c.limit, name};
}

void count(benchmark::State& state, std::uint64_t vertices) {
    using benchmark::Counter;
    state.counters["vertices"] = static_cast<double>(vertices);
    state.counters["vertex"] =
        Counter(static_cast<double>(vertices), Counter::kIsIterationInvariantRate | Counter::kInvert);
}

/// From the control mesh in memory to a mesh of the last level, in whatever memory the library has: what the last round
/// freed, as far as it keeps that.
void full_refinement(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(c);
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        vertices = refine(mesh, *c.scheme, c.levels, c.options()).positions.size();
        benchmark::ClobberMemory();
    }
    count(state, vertices);
}

/// Positions only, again, in buffers that are kept.
void positions_refinement(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(c);
    const PositionRefiner refiner(mesh, *c.scheme, c.levels, c.options());
    std::vector<Vec3d> positions(refiner.mesh().positions.size()), normals(refiner.mesh().normals.size());
    for (auto _ : state) {
        refiner.refine(mesh.positions(), positions, normals);
        benchmark::ClobberMemory();
    }
    count(state, positions.size());
}

void far(benchmark::State& state, Case c) {
    const UniformTask task = task_of(c);
    std::uint64_t vertices = 0;
    for (auto _ : state) vertices = far_uniform(task);
    count(state, vertices);
}

void stencils(benchmark::State& state, Case c) {
    const auto evaluate = stencil_evaluation(task_of(c));
    std::uint64_t vertices = 0;
    for (auto _ : state) vertices = evaluate();
    count(state, vertices);
}

template <class Make>
void in_place(benchmark::State& state, const Case& c, Make make, std::string_view name) {
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        state.PauseTiming();
        auto refine = make(task_of(c, name));
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

constexpr BenchModel k_dense{"spot-quads", "data/models/spot-quads.obj", SchemeKind::catmull_clark};
constexpr std::pair<const char*, const char*> k_usual_schemes[] = {{"cc", "catmull-clark"}, {"loop", "loop"}};

/// @param scheme  what the benchmark's name calls it
template <class Run>
void add(std::string_view scheme, std::string_view method, const Case& c, Run run) {
    const std::string full = fmt::format("{}/{}/{}/{}{}{}", c.model->name, scheme, c.levels, method,
                                         c.limit ? "_limit" : "", c.threads == 2 ? "_2t" : "");
    benchmark::RegisterBenchmark(full.c_str(), run, c)->Unit(benchmark::kMillisecond)->UseRealTime();
}

/// What a peer has, by its name for schemes that are none of the usual two.
template <class Make>
auto by_peer(Make make, std::string_view name = {}) {
    return [=](benchmark::State& state, const Case& c) { in_place(state, c, make, name); };
}

void register_all() {
    const BenchModel* models[] = {find_bench_model("spot-control"), find_bench_model("suzanne"),
                                  find_bench_model("pawn"), &k_dense};
    for (const BenchModel* model : models)
        for (const auto& [label, scheme] : k_usual_schemes)
            for (int levels = 3; levels <= 6; ++levels) {
                for (const bool limit : {false, true}) {
                    const Case one{model, find_scheme(scheme), levels, 1, limit};
                    add(label, "full", one, full_refinement);
                    add(label, "positions", one, positions_refinement);
                    add(label, "positions", {model, one.scheme, levels, 2, limit}, positions_refinement);
                    add(label, "far_double", one, far);
                }
                const Case c{model, find_scheme(scheme), levels, 1};
                add(label, "full", {model, c.scheme, levels, 2}, full_refinement);
                add(label, "stencils", c, stencils);
#ifdef TETRAKIS_BENCH_CGAL
                add(label, "cgal", c, by_peer(cgal_uniform));
#endif
#ifdef TETRAKIS_BENCH_OPENMESH
                add(label, "openmesh", c, by_peer(openmesh_uniform));
#endif
            }
}

void register_schemes() {
    for (const char* name : {"spot-control", "suzanne"}) {
        const BenchModel* smooth = find_bench_model(name);
        for (const SchemeInfo& scheme : scheme_table())
            for (const int threads : {1, 2})
                for (const bool limit : {false, true}) {
                    const Case c{smooth, &scheme, scheme.refinement == Refinement::sqrt3 ? 4 : 5, threads, limit};
                    add(scheme.name, "refine", c, full_refinement);
                    add(scheme.name, "positions", c, positions_refinement);
                }
        // What peers have besides Catmull-Clark and Loop.
        const auto add_peer = [&](std::string_view scheme, int levels, const char* peer, auto make) {
            add(scheme, peer, {smooth, find_scheme(scheme), levels, 1}, by_peer(make, scheme));
        };
#ifdef TETRAKIS_BENCH_CGAL
        add_peer("doo-sabin", 5, "cgal", cgal_uniform);
        add_peer("sqrt3", 4, "cgal", cgal_uniform);
#endif
#ifdef TETRAKIS_BENCH_OPENMESH
        add_peer("modified-butterfly", 5, "openmesh", openmesh_uniform);
        add_peer("sqrt3", 4, "openmesh", openmesh_uniform);
#endif
    }
}

}  // namespace

}  // namespace tetrakis::bench

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    tetrakis::bench::register_all();
    tetrakis::bench::register_schemes();
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
