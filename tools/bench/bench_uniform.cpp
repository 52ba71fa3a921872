// Uniform refinement compared with OpenSubdiv, CGAL and OpenMesh in one run. The counter "vertex" is the time for each
// vertex of the last level.
#include "bench_models.hpp"
#include "peers/uniform_peers.hpp"

#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::bench {

namespace {

/// A model and the parameters of its refinement.
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
        // Peers do not refine texture coordinates.
        data.uvs.clear();
        data.face_uvs.clear();
        data.uv_lines.clear();
        place->second = ControlMesh::build(std::move(data));
        if (c.triangles()) place->second = triangulate(place->second);
    }
    return place->second;
}

UniformTask task_of(const Case& c) {
    // One level of sqrt3 here is two steps of the peers.
    return {mesh_of(c).data(), c.scheme->name, c.scheme->refinement == Refinement::sqrt3 ? 2 * c.levels : c.levels,
            c.limit};
}

void count(benchmark::State& state, std::uint64_t vertices) {
    using benchmark::Counter;
    state.counters["vertices"] = static_cast<double>(vertices);
    state.counters["vertex"] =
        Counter(static_cast<double>(vertices), Counter::kIsIterationInvariantRate | Counter::kInvert);
}

/// From the control mesh in memory to a mesh of the last level. The library may reuse memory that it kept when the last
/// iteration freed its mesh.
void full_refinement(benchmark::State& state, Case c) {
    const ControlMesh& mesh = mesh_of(c);
    std::uint64_t vertices = 0;
    for (auto _ : state) {
        vertices = refine(mesh, *c.scheme, c.levels, c.options()).positions.size();
        benchmark::ClobberMemory();
    }
    count(state, vertices);
}

/// Recomputes positions, and normals with limits, in buffers that are reused.
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

void stencils(benchmark::State& state, Case c) {
    const auto evaluate = stencil_evaluation(task_of(c));
    std::uint64_t vertices = 0;
    for (auto _ : state) vertices = evaluate();
    count(state, vertices);
}

/// Refinement by a peer. Building the peer's own mesh is not timed.
template <class Make>
auto by_peer(Make make) {
    return [=](benchmark::State& state, const Case& c) {
        std::uint64_t vertices = 0;
        for (auto _ : state) {
            state.PauseTiming();
            auto refine = make(task_of(c));
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
    };
}

constexpr BenchModel k_refined[] = {
    k_models[0], k_models[4], k_models[2], {"spot-quads", "data/models/spot-quads.obj", SchemeKind::catmull_clark}};

template <class Run>
void add(std::string_view method, const Case& c, Run run) {
    const std::string full =
        fmt::format("{}/{}/{}/{}{}{}", c.model->name, c.scheme->name == "catmull-clark" ? "cc" : c.scheme->name,
                    c.levels, method, c.limit ? "_limit" : "", c.threads == 2 ? "_2t" : "");
    benchmark::RegisterBenchmark(full.c_str(), run, c)->Unit(benchmark::kMillisecond)->UseRealTime();
}

/// Catmull-Clark and Loop, which all peers have, run at all levels; other schemes at one level of two models.
void register_all(const BenchModel& model, const SchemeInfo& scheme) {
    const bool usual = scheme_from_name(scheme.name).has_value();
    if (!usual && model.name != "spot-control" && model.name != "suzanne") return;
    const int one_level = scheme.refinement == Refinement::sqrt3 ? 4 : 5;
    for (int levels = usual ? 3 : one_level; levels <= (usual ? 6 : one_level); ++levels) {
        for (const int threads : {1, 2})
            for (const bool limit : {false, true}) {
                const Case c{&model, &scheme, levels, threads, limit};
                add("full", c, full_refinement);
                add("positions", c, positions_refinement);
                if (usual && threads == 1) add("far_double", c, by_peer(far_uniform));
            }
        const Case c{&model, &scheme, levels, 1};
        if (usual) add("stencils", c, stencils);
#ifdef TETRAKIS_BENCH_CGAL
        if (usual || scheme.name == "doo-sabin" || scheme.name == "sqrt3") add("cgal", c, by_peer(cgal_uniform));
#endif
#ifdef TETRAKIS_BENCH_OPENMESH
        if (usual || scheme.name == "modified-butterfly" || scheme.name == "sqrt3")
            add("openmesh", c, by_peer(openmesh_uniform));
#endif
    }
}

}  // namespace

}  // namespace tetrakis::bench

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    for (const auto& model : tetrakis::bench::k_refined)
        for (const tetrakis::SchemeInfo& scheme : tetrakis::scheme_table())
            tetrakis::bench::register_all(model, scheme);
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
