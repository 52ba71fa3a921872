#include "../../eval/patches/limit_surface.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../tests/kit/meshes.hpp"
#include "peers/adaptive_peers.hpp"

#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

// Adaptive refinement of triangles: from the control mesh with its data structure to the refined mesh with positions.
// Both libraries know beforehand which faces each round splits, so that the search for them is not timed.
namespace tetrakis::bench {

namespace {

/// A regular triangulation of the square [-1/2, 1/2]^2, joined at opposite sides to a torus, so that no triangle is at
/// a boundary. It is flat except next to the joined sides.
ControlMeshData square(std::uint32_t n) {
    ControlMeshData data = test::grid(n, true, true);
    for (Vec3d& p : data.positions) p = {p.x / n - 0.5, p.y / n - 0.5, p.x == 0 || p.y == 0 ? -0.25 : 0};
    return data;
}

struct Case {
    const char* name;
    bool sqrt3;
    int rounds;
    Selection selection;
};

const ControlMesh& control(const Case& c) {
    static const ControlMesh flat = ControlMesh::build(square(24)), knot = test::model("knot_tri");
    return c.selection == Selection::all ? knot : flat;
}

class Ours {
  public:
    explicit Ours(const Case& c) : case_(c) {
        Hierarchy h = fresh();
        for (int round = 0; round < c.rounds; ++round) {
            // Half triangles of sqrt(3) (odd depth) are also triangles of a round in OpenMesh. Those that the circle
            // cuts are completed first; else soon no triangle with split neighbours would be left on the circle.
            if (c.sqrt3 && c.selection == Selection::circle && round > 0) split_selected(h, 2 * round - 1);
            split_selected(h, c.sqrt3 ? 2 * round : round);
        }
    }
    Hierarchy fresh(bool patches = false) const {
        HierarchyOptions options;
        if (patches) options.limit_positions = std::make_shared<LimitSurface>(control(case_), SchemeKind::loop);
        return make_hierarchy(control(case_), case_.sqrt3 ? "sqrt3" : "loop", options);
    }
    HierarchyMesh refine(Hierarchy& h, MeshPositions positions) const {
        for (const auto& leaves : rounds_) h.refine(leaves);
        return h.to_mesh({.positions = positions});
    }

  private:
    void split_selected(Hierarchy& h, int depth) {
        rounds_.emplace_back();
        for (LeafHandle leaf : h.leaves()) {
            const LeafView view = h.view(leaf);
            if (view.node.depth != depth) continue;
            std::array<Vec3d, 3> corner;
            if (case_.selection != Selection::all) h.limit_positions(std::span(view.corner).first(3), corner);
            if (!selects(case_.selection, corner)) continue;
            rounds_.back().push_back(leaf);
        }
        h.refine(rounds_.back());
    }

    Case case_;
    std::vector<std::vector<LeafHandle>> rounds_;
};

void report(benchmark::State& state, const AdaptiveResult& result) {
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(result.vertices));
    state.counters["vertices"] = static_cast<double>(result.vertices);
    state.counters["faces"] = static_cast<double>(result.faces);
    state.counters["moment"] = result.moment;
}

AdaptiveResult result_of(const PolygonMesh& mesh) {
    AdaptiveResult result{mesh.positions.size(), mesh.face_offsets.size() - 1};
    for (const Vec3d& p : mesh.positions) result.moment += glm::dot(p, p);
    result.moment /= static_cast<double>(result.vertices);
    return result;
}

template <class Run>
void timed(benchmark::State& state, Run&& run) {
    const auto start = std::chrono::steady_clock::now();
    run();
    state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

void ours(benchmark::State& state, Case c, MeshPositions positions, bool patches) {
    RunContext context;
    context.threads = 1;
    with_threads(context, [&] {
        const Ours run(c);
        HierarchyMesh mesh;
        for (auto _ : state) {
            Hierarchy h = run.fresh(patches);
            timed(state, [&] { mesh = run.refine(h, positions); });
        }
        report(state, result_of(mesh.mesh));
    });
}

#ifdef TETRAKIS_BENCH_OPENMESH
void openmesh(benchmark::State& state, Case c) {
    const auto run = openmesh_adaptive({control(c).data(), c.sqrt3, c.rounds, c.selection});
    for (auto _ : state) {
        run->prepare();
        timed(state, [&] { run->refine(); });
    }
    report(state, run->result());
}
#endif

template <class Run>
void add(const Case& c, const std::string& method, Run run) {
    benchmark::RegisterBenchmark((std::string("adaptive/") + c.name + "/" + method).c_str(), run)
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime();
}

[[maybe_unused]] const bool k_registered = [] {
    constexpr Case k_cases[] = {
        {"loop/all", false, 3, Selection::all},       {"loop/disc", false, 4, Selection::disc},
        {"loop/circle", false, 7, Selection::circle}, {"sqrt3/all", true, 4, Selection::all},
        {"sqrt3/disc", true, 5, Selection::disc},     {"sqrt3/circle", true, 9, Selection::circle},
    };
    for (const Case& c : k_cases) {
        add(c, "levels", [c](benchmark::State& state) { ours(state, c, MeshPositions::finest, false); });
        add(c, "limits", [c](benchmark::State& state) { ours(state, c, MeshPositions::limit, false); });
        if (!c.sqrt3)
            add(c, "patch_limits", [c](benchmark::State& state) { ours(state, c, MeshPositions::limit, true); });
#ifdef TETRAKIS_BENCH_OPENMESH
        add(c, "openmesh", [c](benchmark::State& state) { openmesh(state, c); });
#endif
    }
    return true;
}();

}  // namespace

}  // namespace tetrakis::bench
