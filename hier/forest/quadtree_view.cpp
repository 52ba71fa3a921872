#include "quadtree_view.hpp"

#include "../base/parallel.hpp"
#include "../base/radix_sort.hpp"
#include "../base/spread_bits.hpp"

#include <algorithm>
#include <utility>

// The cells are dealt out, in the order of slots, to buckets that follow each other in the order wanted, and each
// bucket is sorted while it is in the cache. Places are unique, so nothing depends on how the work was cut up.
namespace tetrakis {

namespace {

std::uint64_t z_order(LatticePoint p) { return detail::spread_bits(p.x) | detail::spread_bits(p.y) << 1; }

/// The lower corner at k_max_level.
LatticePoint finest(int level, LatticePoint p) {
    const int shift = k_max_level - level;
    return {p.x << shift, p.y << shift};
}

/// Whether one point comes before another along the curve: the highest bit in which they differ says it, y's before
/// x's of the same rank.
bool z_before(LatticePoint p, LatticePoint q) {
    const std::uint32_t x = p.x ^ q.x, y = p.y ^ q.y;
    return x > y && (x ^ y) > y ? p.x < q.x : p.y < q.y;
}

/// The halves of cells that a leaf covers, of each cell the one half with a direction below 4; the other is covered by
/// the leaf across the cell's diagonal. Leaves of odd depth, which have even directions, are such a half or are not; of
/// the others both children are halves, whose bases are the leaf's legs.
struct FirstHalves {
    struct Half {
        std::uint32_t x, y;  // from the leaf's apex to the cell's lower corner, as numbers that wrap
        std::uint8_t edge;   // of the leaf, on the cell's diagonal
    };
    std::uint32_t count;
    std::array<Half, 2> half;
};
constexpr std::array<FirstHalves, 8> make_first_halves() {
    // From the apex, which is the right angle, of direction 0 or 2 to the square's lower corner.
    const auto half = [](const BisectionShape& shape, std::uint8_t edge) {
        return FirstHalves::Half{shape.apex.x - shape.direction / 2, shape.apex.y, edge};
    };
    std::array<FirstHalves, 8> result{};
    for (std::uint8_t direction = 0; direction < 8; ++direction) {
        FirstHalves& first = result[direction];
        const BisectionShape shape{{0, 0}, direction};
        if (direction % 2 == 0) {
            if (direction < 4) first.half[first.count++] = half(shape, 0);
            continue;
        }
        constexpr int k_even_depth = 2;
        for (int bit : {0, 1})
            if (const BisectionShape child = shape.child(k_even_depth, bit); child.direction < 4)
                first.half[first.count++] = half(child, bit == 0 ? 2 : 1);
    }
    return result;
}
constexpr std::array<FirstHalves, 8> k_first_halves = make_first_halves();
// Of a root the second child lies in the next cell, and is no first half there.
static_assert(k_first_halves[BisectionShape::root().direction].half[0].edge == 2 &&
              BisectionShape::root().child(0, 0).direction < 4 && BisectionShape::root().child(0, 1).direction >= 4);

/// Calls visit(lower corner, leaf across) for these halves.
template <class Visit>
void for_each_first_half(const BisectionLeaf& leaf, Visit&& visit) {
    const FirstHalves& first = k_first_halves[leaf.direction];
    const std::uint32_t count = leaf.depth == 0 ? 1 : first.count;
    for (std::uint32_t k = 0; k < count; ++k)
        visit(LatticePoint{leaf.apex.x + first.half[k].x, leaf.apex.y + first.half[k].y},
              leaf.neighbour[first.half[k].edge]);
}

/// How the order of cells is cut: a bucket is a few roots, or a square of one root.
struct Buckets {
    // Of cells, on average: so many, with what sorts them, stay in a cache of half a megabyte (bench_quadtree).
    static constexpr std::uint32_t k_cells = 4096;
    // The bits of a sort key that are left for roots.
    static constexpr int k_most_root_bits = 64 - 2 * k_max_level;
    // So that squares are looked up in a table.
    static constexpr int k_most_levels = 6;

    int root_bits = 0;  ///< a bucket has 2^root_bits roots
    int levels = 0;     ///< or is a square of this level
    std::array<std::uint16_t, 1u << k_most_levels> spread{};

    Buckets(std::uint32_t roots, std::uint32_t slots) {
        const auto cells = [&] { return std::uint64_t{k_cells} * (roots >> root_bits) << 2 * levels; };
        while (root_bits < k_most_root_bits && cells() > 2 * std::uint64_t{slots}) ++root_bits;
        while (root_bits == 0 && levels < k_most_levels && cells() < slots) ++levels;
        for (std::uint32_t i = 0; i < spread.size(); ++i)
            spread[i] = static_cast<std::uint16_t>(detail::spread_bits(i));
    }
    std::uint32_t count(std::uint32_t roots) const { return (((roots - 1) >> root_bits) + 1) << 2 * levels; }
    std::uint32_t of(HalfedgeId root, int level, LatticePoint at) const {
        const std::uint64_t x = std::uint64_t{at.x} << levels >> level, y = std::uint64_t{at.y} << levels >> level;
        return ((root.value >> root_bits) << 2 * levels) | spread[x] | std::uint32_t{spread[y]} << 1;
    }
    /// Rank in a bucket.
    std::uint64_t key(const QuadtreeCell& cell) const {
        const std::uint64_t root = cell.root.value & ((1u << root_bits) - 1);
        return root << 2 * k_max_level | z_order(finest(cell.level, cell.at));
    }
};

struct Ranked {
    std::uint64_t key;
    std::uint32_t number;
};

/// Puts the cells of one bucket in order. The working memory is kept from one to the next.
class BucketSorter {
  public:
    explicit BucketSorter(const Buckets& buckets) : buckets_(buckets) {}

    void sort(QuadtreeCell* cells, std::uint32_t count) {
        ranked_.resize(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            ranked_[i].key = buckets_.key(cells[i]);
            ranked_[i].number = i;
        }
        radix_sort(ranked_, spare_, [](const Ranked& r) { return r.key; });
        copy_.resize(count);
        std::copy_n(cells, count, copy_.data());
        for (std::uint32_t i = 0; i < count; ++i) cells[i] = copy_[ranked_[i].number];
    }

  private:
    const Buckets& buckets_;
    detail::PodArray<Ranked> ranked_, spare_;
    detail::PodArray<QuadtreeCell> copy_;
};

}  // namespace

QuadtreeView::QuadtreeView(const BisectionForest& forest) : mesh_(&forest.mesh()) {
    const std::uint32_t slots = forest.leaf_slots(), roots = mesh_->halfedge_count();
    first_.assign(std::size_t{roots} + 1, 0);
    if (slots == 0) return;  // holes only
    const Buckets buckets(roots, slots);
    const std::uint32_t bucket_count = buckets.count(roots);

    // Blocks of slots, not so many that their counts outweigh the leaves.
    constexpr std::uint32_t k_slots = 1u << 15;
    const std::uint32_t block = std::max(k_slots, bucket_count), block_count = (slots - 1) / block + 1;
    const auto visit_block = [&](std::uint32_t b, auto&& visit) {
        for (std::uint32_t s = b * block, end = std::min<std::uint64_t>(slots, s + std::uint64_t{block}); s < end; ++s)
            if (forest.is_leaf(LeafId(s))) visit(LeafId(s), forest.leaf(LeafId(s)));
    };
    std::vector<std::uint32_t> places(std::size_t{block_count} * bucket_count, 0);
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            std::uint32_t* const counts = places.data() + std::size_t{b} * bucket_count;
            visit_block(b, [&](LeafId, const BisectionLeaf& leaf) {
                const int level = lattice_level(leaf.depth);
                for_each_first_half(leaf, [&](LatticePoint at, LeafId) { ++counts[buckets.of(leaf.cell, level, at)]; });
            });
        },
        1);
    std::vector<std::uint32_t> first(std::size_t{bucket_count} + 1);
    std::uint32_t count = 0;
    for (std::uint32_t k = 0; k < bucket_count; ++k) {
        first[k] = count;
        for (std::uint32_t b = 0; b < block_count; ++b)
            count += std::exchange(places[std::size_t{b} * bucket_count + k], count);
    }
    first[bucket_count] = count;

    cells_.resize(count);
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            std::uint32_t* const next = places.data() + std::size_t{b} * bucket_count;
            visit_block(b, [&](LeafId id, const BisectionLeaf& leaf) {
                const std::uint8_t level = lattice_level(leaf.depth);
                for_each_first_half(leaf, [&](LatticePoint at, LeafId other) {
                    // Field by field: a record put together elsewhere and copied in larger pieces waits for its stores.
                    QuadtreeCell& cell = cells_[next[buckets.of(leaf.cell, level, at)]++];
                    cell.root.value = leaf.cell.value;
                    cell.at.x = at.x;
                    cell.at.y = at.y;
                    cell.level = level;
                    cell.half[0].value = id.value;
                    cell.half[1].value = other.value;
                });
            });
        },
        1);
    const std::uint32_t grain = bucket_count / (count / Buckets::k_cells + 1) + 1;
    for_each_block(bucket_count, grain, [&](std::uint32_t begin, std::uint32_t end) {
        BucketSorter sorter(buckets);
        for (std::uint32_t k = begin; k < end; ++k) {
            sorter.sort(cells_.data() + first[k], first[k + 1] - first[k]);
            if (buckets.levels > 0) continue;
            const std::uint32_t first_root = k << buckets.root_bits;
            const std::uint32_t end_root = std::min(roots - first_root, 1u << buckets.root_bits) + first_root;
            for (std::uint32_t r = first_root, i = first[k]; r < end_root; first_[r++] = i)
                while (i < first[k + 1] && cells_[i].root.value < r) ++i;
        }
    });
    if (buckets.levels > 0)
        for (std::uint32_t r = 0; r < roots; ++r) first_[r] = first[r << 2 * buckets.levels];
    first_[roots] = count;
}

std::optional<std::uint32_t> QuadtreeView::find_finest(HalfedgeId root, LatticePoint at) const {
    const auto begin = cells_.begin() + first_[root.value], end = cells_.begin() + first_[root.value + 1];
    if (begin == end) return std::nullopt;
    const auto after = std::upper_bound(begin, end, at, [](LatticePoint p, const QuadtreeCell& cell) {
        return z_before(p, finest(cell.level, cell.at));
    });
    return static_cast<std::uint32_t>(after - cells_.begin()) - 1;
}

std::optional<std::uint32_t> QuadtreeView::find(HalfedgeId root, int level, LatticePoint at) const {
    const auto found = find_finest(root, finest(level, at));
    if (!found || cells_[*found].level > level) return std::nullopt;
    return found;
}

QuadtreeView::Neighbours QuadtreeView::neighbours(std::uint32_t cell, CellSide side) const {
    const QuadtreeCell& c = cells_[cell];
    // Counted in quarters of the cell: the centres of the two half-size squares beyond the side.
    const std::int64_t x = 4 * std::int64_t{c.at.x}, y = 4 * std::int64_t{c.at.y}, size = std::int64_t{4} << c.level;
    Neighbours result;
    for (std::int64_t along : {1, 3}) {
        CellPoint p{c.root, x + along, y + along};
        switch (side) {
            case CellSide::edge:
                p.y = y - 1;
                break;
            case CellSide::prev_edge:
                p.x = x - 1;
                break;
            case CellSide::next_cell:
                p.x = x + 5;
                break;
            case CellSide::prev_cell:
                p.y = y + 5;
                break;
        }
        if (p.x < 0 || p.y < 0 || p.x > size || p.y > size) p = cross(*mesh_, p, side, size);
        if (!p.root.valid()) return {};
        // At the largest level there is nothing finer, and the quarters do not show.
        const int finer = c.level < k_max_level ? 1 : 0;
        const auto square = [&](std::int64_t q) { return static_cast<std::uint32_t>(q >> (2 - finer)); };
        const auto found = find_finest(p.root, finest(c.level + finer, {square(p.x), square(p.y)}));
        if (!found) return {};
        if (result.count == 0 || result.cell[0] != *found) result.cell[result.count++] = *found;
    }
    return result;
}

}  // namespace tetrakis
