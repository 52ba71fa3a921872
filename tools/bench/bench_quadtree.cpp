#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "peers/quadtree_pattern.hpp"

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

// Restricted quadtrees on a cube's surface: from the six faces to the leaves of a pattern, balanced across sides, as in
// p4est. A face is four corner cells of ours, so level l of a face is our level l - 1. One thread, one rank.
namespace tetrakis::bench {

namespace {

ControlMesh cube() {
    ControlMeshData data;
    for (int v = 0; v < 8; ++v) data.positions.emplace_back(v & 1, v >> 1 & 1, v >> 2);
    data.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    for (std::uint32_t f = 0; f <= 6; ++f) data.face_offsets.push_back(4 * f);
    return ControlMesh::build(std::move(data));
}

/// Of the corner cells, by half-edge.
std::vector<SquareFrame> cell_frames(const ControlMesh& mesh) {
    const auto point = [&](HalfedgeId h) {
        const Vec3d p = mesh.positions()[mesh.origin(h).value];
        return CubePoint{std::lround(p.x), std::lround(p.y), std::lround(p.z)};
    };
    std::vector<SquareFrame> frames;
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i);
        frames.push_back(face_frame(point(h), point(mesh.next(h)), point(mesh.prev(h))));
    }
    return frames;
}

class CubeQuadtree {
  public:
    explicit CubeQuadtree(const CubePattern& pattern) : mesh_(cube()), level_(pattern.level - 1) {
        for (const SquareFrame& frame : cell_frames(mesh_)) wanted_.push_back(pattern.in(frame));
    }

    /// Round by round: a leaf is split if a cell that it covers half of is to be.
    BisectionForest bisected() const {
        BisectionForest forest(mesh_);
        std::vector<LeafId> open, marked, created;
        for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s) open.push_back(LeafId(s));
        for (;;) {
            marked.clear();
            for (LeafId leaf : open)
                if (wants(forest, leaf)) marked.push_back(leaf);
            if (marked.empty()) return forest;
            forest.refine(marked, created);
            std::swap(open, created);
        }
    }

  private:
    static std::int64_t edge(int level) { return k_cube_edge / 2 >> level; }

    bool wants(const BisectionForest& forest, LeafId id) const {
        const BisectionLeaf& leaf = forest.leaf(id);
        const int level = lattice_level(leaf.depth);
        if (level >= level_) return false;
        if (leaf.depth == 0)
            return wanted_[leaf.cell.value].wants(0, 0, edge(0)) ||
                   wanted_[mesh_.next(leaf.cell).value].wants(0, 0, edge(0));
        // By direction: the one square that the leaf is half of, or the two, side by side, that it has a quarter of
        // each; a linear function has a zero in one of these if it has one in both together.
        struct Covered {
            std::int8_t x, y, width, height;  // from the apex
        };
        constexpr std::array<Covered, 8> k_covered{{{0, 0, 1, 1},
                                                    {-1, 0, 2, 1},
                                                    {-1, 0, 1, 1},
                                                    {-1, -1, 1, 2},
                                                    {-1, -1, 1, 1},
                                                    {-1, -1, 2, 1},
                                                    {0, -1, 1, 1},
                                                    {0, -1, 1, 2}}};
        const Covered& c = k_covered[leaf.direction];
        const std::int64_t unit = edge(level);
        return wanted_[leaf.cell.value].wants(unit * (std::int64_t{leaf.apex.x} + c.x),
                                              unit * (std::int64_t{leaf.apex.y} + c.y), unit * c.width,
                                              unit * c.height);
    }

    ControlMesh mesh_;
    std::vector<FramePattern> wanted_;
    int level_;
};

std::int64_t square_count(const BisectionForest& forest) {
    std::int64_t halves = 0;
    for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s)
        if (forest.is_leaf(LeafId(s))) halves += forest.depth(LeafId(s)) % 2 != 0 ? 1 : 2;
    return halves / 2;
}

void count(benchmark::State& state, std::int64_t squares) {
    state.SetItemsProcessed(state.iterations() * squares);
    state.counters["squares"] = static_cast<double>(squares);
}

void ours(benchmark::State& state, CubePattern pattern) {
    const CubeQuadtree quadtree(pattern);
    RunContext context;
    context.threads = 1;
    std::int64_t squares = 0;
    double bytes = 0;
    with_threads(context, [&] {
        for (auto _ : state) {
            const BisectionForest forest = quadtree.bisected();
            state.PauseTiming();
            squares = square_count(forest);
            bytes = static_cast<double>(forest.memory_bytes());
            state.ResumeTiming();
        }
    });
    count(state, squares);
    state.counters["bytes_per_square"] = bytes / static_cast<double>(squares);
}

#ifdef TETRAKIS_BENCH_P4EST
void p4est(benchmark::State& state, CubePattern pattern, bool neighbours) {
    QuadtreeRun run;
    for (auto _ : state) {
        run = run_p4est(pattern, neighbours);
        state.SetIterationTime(run.seconds);
    }
    if (run.squares != square_count(CubeQuadtree(pattern).bisected()))
        state.SkipWithError("p4est and BisectionForest have other squares");
    count(state, run.squares);
}

void p4est_neighbours(benchmark::State& state, CubePattern pattern) { p4est(state, pattern, true); }
void p4est_leaves(benchmark::State& state, CubePattern pattern) { p4est(state, pattern, false); }

#    define TETRAKIS_BENCH_P4EST_ON(name, pattern)                                                      \
        BENCHMARK_CAPTURE(p4est_leaves, name, pattern)->Unit(benchmark::kMillisecond)->UseManualTime(); \
        BENCHMARK_CAPTURE(p4est_neighbours, name, pattern)->Unit(benchmark::kMillisecond)->UseManualTime()
#else
#    define TETRAKIS_BENCH_P4EST_ON(name, pattern) static_assert(true)
#endif

// Faces of the cube cut down to these levels: 1.6 and 1.2 million squares.
constexpr CubePattern k_uniform{9, true}, k_curve{15, false};

}  // namespace

BENCHMARK_CAPTURE(ours, uniform, k_uniform)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(ours, curve, k_curve)->Unit(benchmark::kMillisecond)->UseRealTime();
TETRAKIS_BENCH_P4EST_ON(uniform, k_uniform);
TETRAKIS_BENCH_P4EST_ON(curve, k_curve);

}  // namespace tetrakis::bench
