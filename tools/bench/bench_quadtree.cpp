#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../../hier/forest/vertex_forest.hpp"
#include "../../refine/adaptive/partial_levels.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "quadtree_pattern.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

// Restricted quadtrees on a cube's surface: from the six faces to the leaves of a pattern, balanced across sides, as in
// p4est. A face is four corner cells of ours, so level l of a face is our level l - 1.
//
// One process runs ours and p4est on one rank. `mpirun -n 2 bench_quadtree` runs p4est alone, on that many ranks.
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

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

class CubeQuadtree {
  public:
    explicit CubeQuadtree(const CubePattern& pattern)
        : mesh_(cube()), frames_(cell_frames(mesh_)), level_(pattern.level - 1) {
        for (const SquareFrame& frame : frames_) wanted_.push_back(pattern.in(frame));
    }

    /// Round by round: a leaf is split if a cell that it covers half of is to be.
    BisectionForest bisected() const {
        BisectionForest forest(mesh_);
        std::vector<LeafId> open, marked, created;
        for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s) open.push_back(LeafId(s));
        for (;;) {
            keep(open, marked, [&](std::uint32_t i) {
                constexpr std::size_t k_ahead = 16;
                if (i + k_ahead < open.size()) __builtin_prefetch(&forest.leaf(open[i + k_ahead]));
                return wants(forest, open[i]);
            });
            if (marked.empty()) return forest;
            forest.refine(marked, created);
            std::swap(open, created);
        }
    }

    VertexForest refined(const VertexRoots& roots) const {
        VertexForest forest(roots);
        std::vector<LeafId> open = forest.ordered_leaves(), marked, created;
        for (;;) {
            keep(open, marked, [&](std::uint32_t i) {
                const VertexCell cell = forest.cell(open[i]);
                return wants(HalfedgeId(cell.root), cell.at, cell.level);
            });
            if (marked.empty()) return forest;
            forest.refine(marked, created);
            std::swap(open, created);
        }
    }

    /// Those of dual schemes are the corner cells on a closed mesh.
    VertexRoots roots() const { return PartialLevels(mesh_, *find_scheme("doo-sabin")).vertex_roots(); }

    CubeSquare square(HalfedgeId root, LatticePoint at, int level) const {
        const std::int64_t half = edge(level) / 2;
        return {frames_[root.value].at(edge(level) * at.x + half, edge(level) * at.y + half), level + 1};
    }

  private:
    static std::int64_t edge(int level) { return k_cube_edge / 2 >> level; }

    bool wants(HalfedgeId root, LatticePoint at, int level) const {
        return level < level_ && wanted_[root.value].wants(edge(level) * at.x, edge(level) * at.y, edge(level));
    }
    bool wants(const BisectionForest& forest, LeafId id) const {
        const BisectionLeaf& leaf = forest.leaf(id);
        const int level = lattice_level(leaf.depth);
        if (level >= level_) return false;
        if (leaf.depth == 0) return wants(leaf.cell, {0, 0}, 0) || wants(mesh_.next(leaf.cell), {0, 0}, 0);
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

    /// Those that pass the test, in order.
    template <class Test>
    static void keep(const std::vector<LeafId>& leaves, std::vector<LeafId>& kept, Test&& test) {
        constexpr std::uint32_t k_block = 4096;
        const auto count = static_cast<std::uint32_t>(leaves.size());
        const std::uint32_t blocks = (count + k_block - 1) / k_block;
        std::vector<std::uint32_t> first(blocks + 1, 0);
        kept.resize(count);
        for_each_index(
            blocks,
            [&](std::uint32_t b) {
                std::uint32_t next = b * k_block;
                for (std::uint32_t i = next; i < std::min(count, (b + 1) * k_block); ++i) {
                    kept[next] = leaves[i];
                    next += test(i);
                }
                first[b + 1] = next - b * k_block;
            },
            1);
        for (std::uint32_t b = 0; b < blocks; ++b) {
            const auto begin = kept.begin() + b * k_block;
            std::copy(begin, begin + first[b + 1], kept.begin() + first[b]);
            first[b + 1] += first[b];
        }
        kept.resize(first[blocks]);
    }

    ControlMesh mesh_;
    std::vector<SquareFrame> frames_;
    std::vector<FramePattern> wanted_;
    int level_;
};

RunContext with(int threads) {
    RunContext context;
    context.threads = threads;
    return context;
}

std::int64_t square_count(const BisectionForest& forest) {
    std::int64_t halves = 0;
    for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s)
        if (forest.is_leaf(LeafId(s))) halves += forest.depth(LeafId(s)) % 2 != 0 ? 1 : 2;
    return halves / 2;
}

enum class Ours {
    bisection,  ///< BisectionForest: all links and points in place
    vertices,   ///< VertexForest: plain quadtrees, one thread
};

void ours(benchmark::State& state, CubePattern pattern, Ours kind, int threads) {
    const CubeQuadtree quadtree(pattern);
    const VertexRoots roots = quadtree.roots();
    std::int64_t squares = 0, bytes = 0;
    for (auto _ : state)
        with_threads(with(threads), [&] {
            const auto start = std::chrono::steady_clock::now();
            if (kind == Ours::vertices) {
                const VertexForest forest = quadtree.refined(roots);
                state.SetIterationTime(seconds_since(start));
                squares = forest.leaf_count();
                bytes = static_cast<std::int64_t>(forest.memory_bytes());
                return;
            }
            const BisectionForest forest = quadtree.bisected();
            state.SetIterationTime(seconds_since(start));
            squares = square_count(forest);
            bytes = static_cast<std::int64_t>(forest.memory_bytes());
        });
    state.SetItemsProcessed(state.iterations() * squares);
    state.counters["squares"] = static_cast<double>(squares);
    state.counters["bytes_per_square"] = static_cast<double>(bytes) / static_cast<double>(squares);
}

#ifdef TETRAKIS_BENCH_P4EST
void theirs(benchmark::State& state, CubePattern pattern, const P4est* p4est, bool neighbours) {
    QuadtreeRun run;
    double refine = 0;
    for (auto _ : state) {
        run = p4est->run(pattern, neighbours);
        refine += run.refine_seconds;
        state.SetIterationTime(run.refine_seconds + run.balance_seconds + run.neighbour_seconds);
    }
    state.SetItemsProcessed(state.iterations() * run.squares);
    state.counters["squares"] = static_cast<double>(run.squares);
    state.counters["refine_ms"] = 1e3 * refine / static_cast<double>(state.iterations());
}

/// Ends the program unless p4est and VertexForest make the same squares, and BisectionForest as many.
void require_equal(const P4est& p4est) {
    for (const bool everywhere : {false, true}) {
        const CubePattern pattern{everywhere ? 4 : 9, everywhere};
        const CubeQuadtree quadtree(pattern);
        std::vector<CubeSquare> theirs, leaves;
        p4est.run(pattern, false, &theirs);
        const BisectionForest bisection = quadtree.bisected();
        const VertexForest forest = quadtree.refined(quadtree.roots());
        for (LeafId leaf : forest.ordered_leaves()) {
            const VertexCell cell = forest.cell(leaf);
            leaves.push_back(quadtree.square(HalfedgeId(cell.root), cell.at, cell.level));
        }
        for (auto* squares : {&theirs, &leaves}) std::sort(squares->begin(), squares->end());
        if (theirs == leaves && square_count(bisection) == static_cast<std::int64_t>(theirs.size())) continue;
        std::fprintf(stderr,
                     "bench_quadtree: p4est has %zu squares, BisectionForest %lld, VertexForest %zu, not the same\n",
                     theirs.size(), static_cast<long long>(square_count(bisection)), leaves.size());
        std::exit(1);
    }
}

/// For all ranks but the first.
class Silent final : public benchmark::BenchmarkReporter {
    bool ReportContext(const Context&) override { return true; }
    void ReportRuns(const std::vector<Run>&) override {}
};
#endif

// All ranks must run the same number of times, so it is fixed.
constexpr int k_runs = 5;

template <class Run>
void add(const std::string& name, Run run) {
    benchmark::RegisterBenchmark(name.c_str(), run)->Unit(benchmark::kMillisecond)->Iterations(k_runs)->UseManualTime();
}

// Faces of the cube cut down to these levels: 1.6 and 1.2 million squares.
constexpr std::pair<const char*, CubePattern> k_patterns[] = {{"uniform", {9, true}}, {"curve", {15, false}}};

void register_ours() {
    for (const auto& [name, pattern] : k_patterns) {
        const std::string prefix = std::string("quadtree/") + name + "/";
        const CubePattern p = pattern;
        for (const int threads : {1, 2}) {
            const std::string suffix = "/threads:" + std::to_string(threads);
            add(prefix + "bisection" + suffix,
                [=](benchmark::State& state) { ours(state, p, Ours::bisection, threads); });
        }
        add(prefix + "vertices/threads:1", [=](benchmark::State& state) { ours(state, p, Ours::vertices, 1); });
    }
}

}  // namespace

}  // namespace tetrakis::bench

int main(int argc, char** argv) {
    using namespace tetrakis::bench;
#ifdef TETRAKIS_BENCH_P4EST
    const P4est p4est(&argc, &argv);
    benchmark::Initialize(&argc, argv);
    for (const auto& [name, pattern] : k_patterns)
        for (const bool neighbours : {false, true})
            add(std::string("quadtree/") + name + (neighbours ? "/p4est_neighbours" : "/p4est") +
                    "/ranks:" + std::to_string(p4est.ranks()),
                [&p4est, p = pattern, neighbours](benchmark::State& state) { theirs(state, p, &p4est, neighbours); });
    if (p4est.ranks() > 1) {
        Silent silent;
        if (p4est.rank() == 0)
            benchmark::RunSpecifiedBenchmarks();
        else
            benchmark::RunSpecifiedBenchmarks(&silent);
        benchmark::Shutdown();
        return 0;
    }
    require_equal(p4est);
#else
    benchmark::Initialize(&argc, argv);
#endif
    register_ours();
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
