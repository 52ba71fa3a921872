#include "terrain_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/bisection_forest.hpp"
#include "../tessellate/shading_normals.hpp"
#include "grid_triangle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis {

namespace {

using detail::GridTriangle;
using detail::GridVertex;
using detail::in_samples;
using detail::k_grid_unit;
using detail::middle;
using detail::sampled;

void check(const HeightGrid& grid, const TerrainOptions& options) {
    if (!(options.max_error >= 0 && std::isfinite(options.max_error)))
        throw Error(ErrorCode::invalid_input,
                    fmt::format("a largest error of {}; it has to be zero or a positive number", options.max_error));
    const auto [across, down] = options.tiles;
    if (across < 1 || down < 1 || across >= grid.columns || down >= grid.rows)
        throw Error(ErrorCode::invalid_input,
                    fmt::format("{} x {} tiles; a grid of {} x {} samples can have 1 x 1 to {} x {}", across, down,
                                grid.columns, grid.rows, grid.columns - 1, grid.rows - 1));
}

/// Number of roots, a power of two, into which `longer` is cut: they are about square, and a sample wide or more.
std::uint32_t roots_along(double longer, double shorter) {
    std::uint32_t count = 1;
    while (longer > 1.5 * shorter * count && 2 * count <= longer) count *= 2;
    return count;
}

/// The root quads into which a grid is cut, tile by tile.
struct Roots {
    ControlMesh mesh;
    std::uint32_t faces_of_tile = 1;
    std::vector<std::array<std::int32_t, 2>> places;  ///< grid coordinates of its vertices, then of its faces' centres
};

/// Samples at which an axis is cut: into `tiles` tiles, and each tile into `parts` parts.
std::vector<std::int32_t> cuts_of(std::uint32_t length, std::uint32_t tiles, std::uint32_t parts) {
    std::vector<std::int32_t> cuts;
    for (std::uint64_t i = 0; i <= std::uint64_t{tiles} * parts; ++i)
        cuts.push_back(static_cast<std::int32_t>(i * length / (std::uint64_t{tiles} * parts)));
    return cuts;
}

Roots roots_of(const HeightGrid& grid, const std::array<std::uint32_t, 2>& tiles) {
    const std::uint32_t width = (grid.columns - 1) / tiles[0], height = (grid.rows - 1) / tiles[1];
    const std::uint32_t across = roots_along(width, height), down = roots_along(height, width);
    const std::vector<std::int32_t> xs = cuts_of(grid.columns - 1, tiles[0], across),
                                    ys = cuts_of(grid.rows - 1, tiles[1], down);
    const auto columns = static_cast<std::uint32_t>(xs.size());
    ControlMeshData data;
    std::vector<std::array<std::int32_t, 2>> places;
    for (const std::int32_t y : ys)
        for (const std::int32_t x : xs) {
            places.push_back({x * k_grid_unit, y * k_grid_unit});
            data.positions.emplace_back(x, -y, 0);
        }
    data.face_offsets = {0};
    for (std::uint32_t face = 0; face < tiles[0] * tiles[1] * across * down; ++face) {
        const std::uint32_t tile = face / (across * down), part = face % (across * down);
        const std::uint32_t c = tile % tiles[0] * across + part % across, r = tile / tiles[0] * down + part / across;
        const std::uint32_t v = r * columns + c;
        for (const std::uint32_t corner : {v, v + columns, v + columns + 1, v + 1})
            data.face_vertices.push_back(corner);
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        const auto &p = places[v], &q = places[v + columns + 1];
        places.push_back({middle(p[0], q[0]), middle(p[1], q[1])});
    }
    return {ControlMesh::build(std::move(data)), across * down, std::move(places)};
}

class TerrainRefinement {
  public:
    TerrainRefinement(const HeightGrid& grid, const Roots& roots, const TerrainOptions& options)
        : grid_(grid), limit_(options.max_error), context_(options.context), forest_(roots.mesh) {
        for (const auto& [x, y] : roots.places) vertices_.push_back(sampled(grid_, x, y));
    }

    /// Splits leaves until no sample is farther from its leaf than the limit.
    void refine() {
        const std::vector<LeafId> roots = forest_.ordered_leaves();
        detail::PoolVector<LeafId> fresh(roots.begin(), roots.end()), next;
        const double most_rounds = 2 * std::log2(std::max(grid_.columns, grid_.rows)) + 4;
        for (int rounds = 0; !fresh.empty(); ++rounds) {
            const auto round = static_cast<std::uint8_t>(1 + rounds % 255);
            if (round == 1) std::ranges::fill(made_in_, 0);
            context_.report("refine", 0.6 * std::min(1.0, rounds / most_rounds));
            detail::PoolVector<std::uint8_t> too_far(fresh.size(), 0);
            for_each_index(
                static_cast<std::uint32_t>(fresh.size()),
                [&](std::uint32_t i) {
                    prefetch(fresh, i);
                    too_far[i] = triangle(forest_.leaf(fresh[i]).vertex).error(limit_) > limit_;
                },
                16);
            reserve(forest_.leaf_count() + std::ranges::count(too_far, 1));  // more where other leaves have to be split
            next.clear();
            const std::size_t known_vertices = vertices_.size();
            for (std::size_t i = 0; i < fresh.size(); ++i) {
                if (i + 2 * k_ahead < fresh.size()) __builtin_prefetch(&forest_.leaf(fresh[i + 2 * k_ahead]), 1);
                if (i + k_ahead < fresh.size())
                    for (const LeafId beside : forest_.leaf(fresh[i + k_ahead]).neighbour)
                        if (beside.valid()) __builtin_prefetch(&forest_.leaf(beside), 1);
                if (too_far[i] != 0) split(fresh[i], round, next);
            }
            // Heights of new vertices are read by all threads, as samples are far apart in memory.
            for_each_index(static_cast<std::uint32_t>(vertices_.size() - known_vertices), [&](std::uint32_t i) {
                GridVertex& vertex = vertices_[known_vertices + i];
                vertex = sampled(grid_, vertex.x, vertex.y);
            });
            check_memory();
            std::swap(fresh, next);
        }
    }

    /// Merges diamonds: each thread makes all passes over one block of leaves while that is in the cache, then over the
    /// next. Diamonds that reach into several blocks follow in larger blocks, at last in one block of all leaves.
    void merge() {
        constexpr int k_passes = 3;  // one more would save 2 % of the triangles, one less would cost 10 % more
        std::vector<Block> blocks = make_blocks();
        changed_.assign(vertices_.size(), 0);
        double done = 0.6;
        for (int pass = 1;; pass += k_passes) {
            for_each_reported(static_cast<std::uint32_t>(blocks.size()), 1, context_, "merge", std::exchange(done, 0.9),
                              0.9, [&](std::uint32_t b) { merge_inside(blocks[b], pass, pass + k_passes); });
            for (const Block& block : blocks)
                for (const Diamond& diamond : block.merged) forest_.free_folded(diamond);
            if (blocks.size() == 1) break;
            blocks = larger_blocks(blocks);
            block_shift_ += k_block_bits;
        }
    }

    /// @param faces_of_tile  number of root faces in a tile
    Terrain result(bool y_up, std::uint32_t faces_of_tile) const {
        context_.report("output", 0.9);
        ExportedTriangles exported = forest_.exported();
        Terrain terrain;
        terrain.mesh.triangles = std::move(exported.triangles);
        for (std::uint32_t face = 0; face <= forest_.mesh().face_count(); face += faces_of_tile) {
            const auto first = std::lower_bound(exported.faces.begin(), exported.faces.end(), FaceId(face));
            terrain.first_triangle.push_back(static_cast<std::uint32_t>(first - exported.faces.begin()));
        }
        detail::resize_large(terrain.mesh.positions, exported.points.size());
        for_each_index(static_cast<std::uint32_t>(exported.points.size()), [&](std::uint32_t i) {
            const GridVertex& v = vertices_[exported.points[i].value];
            const double x = grid_.origin.x + grid_.spacing.x * in_samples(v.x),
                         y = grid_.origin.y - grid_.spacing.y * in_samples(v.y);
            terrain.mesh.positions[i] = y_up ? Vec3d(x, v.z, -y) : Vec3d(x, y, v.z);
        });
        detail::PoolVector<double> errors(exported.leaves.size());
        for_each_index(
            static_cast<std::uint32_t>(errors.size()),
            [&](std::uint32_t i) {
                prefetch(exported.leaves, i);
                errors[i] = triangle(forest_.leaf(exported.leaves[i]).vertex).error(std::numeric_limits<double>::max());
            },
            64);
        for (const double error : errors) terrain.largest_error = std::max(terrain.largest_error, error);
        context_.report("output", 1);
        return terrain;
    }

  private:
    using Corners = std::array<PointId, 3>;
    static constexpr std::size_t k_ahead = 4;  // prefetch distance in leaves: the loops are bound by memory latency
    static constexpr int k_block_bits = 4;  // bits of paths by which the next larger blocks differ: 16 times the leaves

    GridTriangle triangle(const Corners& points) const {
        return {grid_, {vertices_[points[0].value], vertices_[points[1].value], vertices_[points[2].value]}};
    }
    /// Makes room for leaves, which are about twice as many as their points.
    void reserve(std::uint64_t leaves) {
        forest_.reserve(leaves, leaves / 2);
        forest_.map_room();
        made_in_.resize(forest_.leaf_capacity(), 0);
    }
    /// Prefetches for a loop over leaves that is at index `i`.
    void prefetch(std::span<const LeafId> leaves, std::size_t i) const {
        if (i + 3 * k_ahead < leaves.size()) __builtin_prefetch(&forest_.leaf(leaves[i + 3 * k_ahead]).vertex);
        if (i + 2 * k_ahead < leaves.size())
            for (const PointId p : forest_.leaf(leaves[i + 2 * k_ahead]).vertex)
                __builtin_prefetch(&vertices_[p.value]);
        if (i + k_ahead < leaves.size()) triangle(forest_.leaf(leaves[i + k_ahead]).vertex).prefetch();
    }
    /// @throws Error  memory_limit
    void check_memory() const {
        const std::uint64_t bytes =
            forest_.memory_bytes() + vertices_.capacity() * sizeof(GridVertex) + grid_.heights.size() * sizeof(float);
        detail::check_memory(fmt::format("{} triangles before merging and the grid need", forest_.leaf_count()), bytes,
                             context_.max_memory_bytes, "use a larger error");
    }

    /// Splits a leaf; the heights of new vertices are left to the caller.
    /// @param next  receives the leaves that splits have made in this round, each once
    void split(LeafId leaf, std::uint8_t round, detail::PoolVector<LeafId>& next) {
        if (made_in_[leaf.value] == round) return;  // an earlier split included this leaf; a child has its slot
        const auto changed = [&](const Diamond& diamond) {
            const Corners &child0 = forest_.leaf(diamond.pairs[0][0]).vertex,
                          &child1 = forest_.leaf(diamond.pairs[0][1]).vertex;
            const GridVertex a = vertices_[child0[1].value], b = vertices_[child1[0].value];
            if (diamond.midpoint.value >= vertices_.size()) vertices_.resize(diamond.midpoint.value + std::size_t{1});
            vertices_[diamond.midpoint.value] = {middle(a.x, b.x), middle(a.y, b.y), 0};
            for (const auto& pair : diamond.siblings())
                for (const LeafId child : pair)
                    if (std::exchange(made_in_[child.value], round) != round) next.push_back(child);
        };
        while (!forest_.split_diamond(leaf, changed)) reserve(forest_.leaf_capacity() / 16 * 17 + 1024);
    }

    /// Leaves that follow each other in the order of their paths: a subtree, or a coarser leaf.
    struct Block {
        std::uint32_t number;
        std::vector<LeafId> slots{};  ///< of leaves to consider; a merged leaf keeps the slot of its first child
        std::vector<Diamond> merged{};
        std::vector<LeafId> across{};  ///< first leaves of diamonds that reach beyond the block
    };
    std::vector<Block> make_blocks() {
        constexpr double k_leaves = 8192;  // in a block, about: leaves and samples then fit into a core's cache
        const double roots = forest_.mesh().halfedge_count();
        const int depth =
            std::max(0, static_cast<int>(std::log2(std::max(1.0, forest_.leaf_count() / k_leaves / roots))));
        const auto block_of = [&](LeafId id) {
            const BisectionLeaf& leaf = forest_.leaf(id);
            const std::uint64_t path =
                leaf.depth > depth ? leaf.path >> (leaf.depth - depth) : leaf.path << (depth - leaf.depth);
            return static_cast<std::uint32_t>((std::uint64_t{forest_.root(id).value} << depth) + path);
        };
        std::vector<Block> blocks;
        const std::vector<LeafId> leaves = forest_.ordered_leaves();
        for (auto begin = leaves.begin(), end = begin; begin != leaves.end(); begin = end) {
            end = std::ranges::upper_bound(begin, leaves.end(), block_of(*begin), {}, block_of);
            blocks.push_back({block_of(*begin), {begin, end}});
        }
        apart_.assign(vertices_.size(), 0);
        for_each_index(
            static_cast<std::uint32_t>(blocks.size()),
            [&](std::uint32_t b) {
                for (const LeafId id : blocks[b].slots)
                    for (std::size_t side = 0; side < 3; ++side) {
                        const BisectionLeaf& leaf = forest_.leaf(id);
                        const LeafId beside = leaf.neighbour[side];
                        const std::uint32_t bits = beside < id ? blocks[b].number ^ block_of(beside) : 0;
                        if (bits != 0)
                            for (const PointId end : {leaf.vertex[side], leaf.vertex[(side + 1) % 3]})
                                std::atomic_ref(apart_[end.value]).fetch_or(bits, std::memory_order_relaxed);
                    }
            },
            1);
        return blocks;
    }
    /// The next larger blocks, with the leaves that their parts could not merge.
    static std::vector<Block> larger_blocks(const std::vector<Block>& blocks) {
        std::vector<Block> larger;
        for (const Block& block : blocks) {
            const std::uint32_t number = block.number >> k_block_bits;
            if (larger.empty() || number != larger.back().number) larger.push_back({number});
            larger.back().slots.insert(larger.back().slots.end(), block.across.begin(), block.across.end());
        }
        return larger;
    }
    /// Whether all leaves around a point of a leaf are in the leaf's block. The records of other leaves must not be
    /// read: another thread may be writing them. Merging keeps this true: both children of a leaf are in the same
    /// block, or are a block each.
    bool is_inside(PointId point) const { return apart_[point.value] >> block_shift_ == 0; }

    /// @param first, end  numbers of the passes; they continue from smaller to larger blocks
    void merge_inside(Block& block, int first, int end) {
        for (int pass = first; pass < end; ++pass) {
            block.across.clear();
            std::size_t kept = 0;
            for (std::size_t i = 0; i < block.slots.size(); ++i) {
                if (pass == first) prefetch(block.slots, i);
                const LeafId leaf = block.slots[i];
                if (!is_first_child(leaf)) continue;  // for good: leaves are not split any more
                block.slots[kept++] = leaf;
                if (!is_inside(forest_.leaf(leaf).vertex[2])) {
                    block.across.push_back(leaf);
                    continue;
                }
                const Diamond diamond = forest_.find_diamond(leaf);
                if (diamond.pair_count == 0 || diamond.pairs[0][0] != leaf) continue;
                const Corners4 corners = corners_of(diamond);
                if (!std::ranges::all_of(corners, [&](PointId p) { return is_inside(p); }))
                    block.across.push_back(leaf);
                else if ((pass == first || changed_since(pass - 1, diamond)) && fit_corners(diamond, pass)) {
                    forest_.fold_diamond(diamond);
                    block.merged.push_back(diamond);
                }
            }
            block.slots.resize(kept);
        }
    }
    bool is_first_child(LeafId id) const {
        return forest_.is_leaf(id) && forest_.depth(id) > 0 && (forest_.leaf(id).path & 1) == 0;
    }

    /// The triangle of which two leaves are the children.
    Corners parent(const std::array<LeafId, 2>& pair) const {
        const Corners &child0 = forest_.leaf(pair[0]).vertex, &child1 = forest_.leaf(pair[1]).vertex;
        return {child0[1], child1[0], child0[0]};
    }

    struct Corners4 {
        std::array<PointId, 4> points;
        std::size_t count = 0;
        const PointId* begin() const { return points.data(); }
        const PointId* end() const { return points.data() + count; }
    };
    /// Corners of a diamond; three if it is at the grid's border.
    Corners4 corners_of(const Diamond& diamond) const {
        Corners4 corners;
        for (const auto& pair : diamond.siblings())
            for (const PointId p : parent(pair))
                if (std::find(corners.begin(), corners.end(), p) == corners.end()) corners.points[corners.count++] = p;
        return corners;
    }
    /// Whether a height or leaf at the diamond's corners changed in `pass` or later.
    bool changed_since(int pass, const Diamond& diamond) const {
        const Corners4 corners = corners_of(diamond);
        return std::any_of(corners.begin(), corners.end(), [&](PointId p) { return changed_[p.value] >= pass; });
    }

    /// Moves the heights of a diamond's corners so that its triangles can be merged. If no such move is found, returns
    /// false and restores the heights. Leaves around the diamond stay within the limit.
    bool fit_corners(const Diamond& diamond, int pass) {
        std::array<Corners, 2> both;
        for (std::uint32_t i = 0; i < diamond.pair_count; ++i) both[i] = parent(diamond.pairs[i]);
        const std::span<const Corners> parents = std::span(both).first(diamond.pair_count);
        const auto within_limit = [&](const Corners& points) { return triangle(points).error(limit_) <= limit_; };
        const Corners4 corners = corners_of(diamond);
        std::array<float, 4> before;
        for (std::size_t k = 0; k < corners.count; ++k) before[k] = vertices_[corners.points[k].value].z;
        bool fits = false;
        for (std::size_t k = 0; k < corners.count && !fits; ++k)
            fits = move(corners.points[k], diamond, parents) && std::ranges::all_of(parents, within_limit);
        for (std::size_t k = 0; k < corners.count; ++k) {
            const std::uint32_t p = corners.points[k].value;
            if (fits)
                changed_[p] = static_cast<std::uint8_t>(pass);
            else
                vertices_[p].z = before[k];
        }
        return fits;
    }

    /// Moves a corner's height to the best one for the merged triangles, as far as the leaves around it allow.
    /// @return  whether the merged triangles may then be within the limit
    bool move(PointId corner, const Diamond& diamond, std::span<const Corners> parents) {
        constexpr double k_least_weight = 0.02, k_margin = 0.1;
        constexpr double k_least_share = 0.1;  // of the wanted move; a smaller part hardly ever helps another corner
        const double hopeless = limit_;        // a larger gap is hardly ever closed by other corners
        GridTriangle::Interval wanted;
        for (const Corners& points : parents) {
            const auto k = std::find(points.begin(), points.end(), corner);
            if (k == points.end()) {
                if (triangle(points).error(limit_) > limit_) return false;
                continue;
            }
            triangle(points).narrow(wanted, static_cast<std::size_t>(k - points.begin()), limit_, k_least_weight,
                                    hopeless);
            if (wanted.gap() > hopeless) return false;
        }
        if (wanted.has(0)) return true;
        const double margin = k_margin * (wanted.high - wanted.low);
        double by = margin < 0       ? (wanted.low + wanted.high) / 2
                    : wanted.low > 0 ? wanted.low + margin
                                     : wanted.high - margin;
        const double least = k_least_share * std::abs(by);
        const bool far_enough = for_each_outside(corner, diamond, [&](LeafId id) {
            const BisectionLeaf& leaf = forest_.leaf(id);
            by = triangle(leaf.vertex).allowed(by, corner_of(leaf, corner), limit_);
            return std::abs(by) > least;
        });
        if (!far_enough) return false;
        GridVertex& vertex = vertices_[corner.value];
        const double to = double{vertex.z} + by;
        auto rounded = static_cast<float>(to);
        if (by > 0 ? rounded > to : rounded < to) rounded = std::nextafter(rounded, vertex.z);
        vertex.z = rounded;
        return wanted.has(by);
    }

    /// Calls visit(leaf) for the leaves around a diamond's corner that are not its own, until it returns false.
    template <class Visit>
    bool for_each_outside(PointId corner, const Diamond& diamond, const Visit& visit) const {
        const auto own = [&](LeafId leaf) {
            return std::any_of(diamond.siblings().begin(), diamond.siblings().end(),
                               [&](const auto& pair) { return leaf == pair[0] || leaf == pair[1]; });
        };
        LeafId at;
        // Walks around `corner` through the sides counter-clockwise (2) or clockwise (0) from it in each leaf.
        const auto turn = [&](std::size_t side) {
            while (at.valid() && !own(at)) {
                if (!visit(at)) return false;
                const BisectionLeaf& leaf = forest_.leaf(at);
                at = leaf.neighbour[(corner_of(leaf, corner) + side) % 3];
            }
            return true;
        };
        LeafId backwards;
        for (const auto& pair : diamond.siblings())
            for (const LeafId id : pair) {
                const BisectionLeaf& leaf = forest_.leaf(id);
                if (leaf.vertex[0] == corner) backwards = leaf.neighbour[0];
                if (leaf.vertex[1] != corner) continue;
                at = leaf.neighbour[0];
                if (!turn(2)) return false;
                if (at.valid()) return true;  // all around
            }
        at = backwards;
        return turn(0);
    }
    static std::size_t corner_of(const BisectionLeaf& leaf, PointId point) {
        return leaf.vertex[0] == point ? 0 : leaf.vertex[1] == point ? 1 : 2;
    }

    const HeightGrid& grid_;
    double limit_;
    const RunContext& context_;
    BisectionForest forest_;
    detail::PoolVector<std::uint8_t> made_in_;  // by the forest's leaves: last round that made one in this slot
    // By the forest's points:
    detail::PodArray<GridVertex> vertices_;
    detail::PoolVector<std::uint8_t> changed_;  // last pass that changed the leaves around a point, or its height
    detail::PoolVector<std::uint32_t> apart_;   // bits in which the smallest blocks of the leaves around a point differ
    int block_shift_ = 0;  // shift from the numbers of the smallest blocks to the numbers of the present ones
};

}  // namespace

Terrain terrain_mesh(const HeightGrid& grid, const TerrainOptions& options) {
    detail::check_surface(grid);
    check(grid, options);
    return with_threads(options.context, [&] {
        const Roots roots = roots_of(grid, options.tiles);
        TerrainRefinement refinement(grid, roots, options);
        refinement.refine();
        refinement.merge();
        Terrain terrain = refinement.result(options.y_up, roots.faces_of_tile);
        if (options.normals) detail::geometric_normals(terrain.mesh);
        return terrain;
    });
}

TriangleMesh terrain_tile(const Terrain& terrain, std::size_t tile) {
    TriangleMesh mesh;
    mesh.triangles.assign(terrain.mesh.triangles.begin() + terrain.first_triangle[tile],
                          terrain.mesh.triangles.begin() + terrain.first_triangle[tile + 1]);
    std::vector<std::uint32_t> used;
    for (const auto& triangle : mesh.triangles) used.insert(used.end(), triangle.begin(), triangle.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (auto& triangle : mesh.triangles)
        for (std::uint32_t& v : triangle)
            v = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin());
    for (const std::uint32_t v : used) {
        mesh.positions.push_back(terrain.mesh.positions[v]);
        if (!terrain.mesh.normals.empty()) mesh.normals.push_back(terrain.mesh.normals[v]);
    }
    return mesh;
}

}  // namespace tetrakis
