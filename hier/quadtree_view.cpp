#include "tetrakis/hier/quadtree_view.hpp"

#include "tetrakis/hier/huge_memory.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/hier/pod_array.hpp"
#include "tetrakis/hier/radix_sort.hpp"

#include <algorithm>
#include <tuple>

namespace tetrakis {

namespace {

/// Puts a zero before each bit of a number below 2^32.
std::uint64_t spread_bits(std::uint64_t x) {
    x = (x | x << 16) & 0x0000'FFFF'0000'FFFFull;
    x = (x | x << 8) & 0x00FF'00FF'00FF'00FFull;
    x = (x | x << 4) & 0x0F0F'0F0F'0F0F'0F0Full;
    x = (x | x << 2) & 0x3333'3333'3333'3333ull;
    return (x | x << 1) & 0x5555'5555'5555'5555ull;
}

std::uint64_t z_order(int level, LatticePoint p) {
    const int shift = k_max_level - level;
    return spread_bits(std::uint64_t{p.x} << shift) | spread_bits(std::uint64_t{p.y} << shift) << 1;
}

/// Inverse of spread_bits(): every second bit.
std::uint32_t gather_bits(std::uint64_t x) {
    x &= 0x5555'5555'5555'5555ull;
    x = (x | x >> 1) & 0x3333'3333'3333'3333ull;
    x = (x | x >> 2) & 0x0F0F'0F0F'0F0F'0F0Full;
    x = (x | x >> 4) & 0x00FF'00FF'00FF'00FFull;
    x = (x | x >> 8) & 0x0000'FFFF'0000'FFFFull;
    return static_cast<std::uint32_t>(x | x >> 16);
}

struct ViewCell {
    std::uint64_t key;
    std::array<LeafId, 2> half;
    std::uint8_t level;
};

/// Calls visit(root, shape, leaf across its base) for the halves of cells that the leaf covers, of each cell the one
/// half with a direction below 4. The base is the cell's diagonal, so the leaf across covers the other half.
template <class Visit>
void for_each_first_half(const BisectionForest& forest, LeafId id, Visit&& visit) {
    const auto is_first = [](const BisectionShape& shape) { return shape.direction < 4; };
    const BisectionLeaf& leaf = forest.leaf(id);
    const BisectionShape shape = leaf.shape();
    if (leaf.depth % 2 != 0) {
        if (is_first(shape)) visit(leaf.cell, shape, leaf.neighbour[0]);
        return;
    }
    // Both children are halves; their bases are the leaf's legs.
    for (int bit : {0, 1}) {
        const BisectionShape child = shape.child(leaf.depth, bit);
        if (!is_first(child)) continue;
        const HalfedgeId cell = leaf.depth == 0 && bit == 1 ? forest.mesh().next(leaf.cell) : leaf.cell;
        visit(cell, child, leaf.neighbour[bit == 0 ? 2 : 1]);
    }
}

}  // namespace

QuadtreeView::QuadtreeView(const BisectionForest& forest) : mesh_(&forest.mesh()) {
    const std::uint32_t slots = forest.leaf_slots(), roots = mesh_->halfedge_count();
    std::vector<std::uint32_t> first(roots + 1, 0);
    for (std::uint32_t s = 0; s < slots; ++s)
        if (forest.is_leaf(LeafId(s)))
            for_each_first_half(forest, LeafId(s),
                                [&](HalfedgeId root, const BisectionShape&, LeafId) { ++first[root.value + 1]; });
    for (std::uint32_t r = 0; r < roots; ++r) first[r + 1] += first[r];

    const std::uint32_t count = first[roots];
    detail::PodArray<ViewCell> all;
    all.resize(count);
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t s = 0; s < slots; ++s) {
        const LeafId leaf(s);
        if (!forest.is_leaf(leaf)) continue;
        for_each_first_half(forest, leaf, [&](HalfedgeId root, const BisectionShape& shape, LeafId other) {
            const LatticePoint a = shape.a(), b = shape.b(), p = shape.apex;
            const LatticePoint at{std::min({a.x, b.x, p.x}), std::min({a.y, b.y, p.y})};
            const std::uint8_t level = lattice_level(forest.depth(leaf));
            all[next[root.value]++] = {z_order(level, at), {leaf, other}, level};
        });
    }
    detail::resize_large(keys_, count);
    detail::resize_large(cells_, count);
    constexpr std::uint32_t k_roots_per_task = 8;
    for_each_block(roots, k_roots_per_task, [&](std::uint32_t begin, std::uint32_t end) {
        std::vector<ViewCell> cells, spare;
        for (std::uint32_t r = begin; r < end; ++r) {
            detail::reserve_large(cells, first[r + 1] - first[r]);
            detail::reserve_large(spare, first[r + 1] - first[r]);
            cells.assign(all.data() + first[r], all.data() + first[r + 1]);
            radix_sort(cells, spare, [](const ViewCell& cell) { return cell.key; });
            for (std::uint32_t i = first[r]; const ViewCell& cell : cells) {
                const int shift = k_max_level - cell.level;
                keys_[i] = cell.key;
                cells_[i++] = {HalfedgeId(r),
                               {gather_bits(cell.key) >> shift, gather_bits(cell.key >> 1) >> shift},
                               cell.level,
                               cell.half};
            }
        }
    });
}

std::optional<std::uint32_t> QuadtreeView::find_key(HalfedgeId root, std::uint64_t key) const {
    std::uint32_t low = 0, high = static_cast<std::uint32_t>(cells_.size());
    while (low < high) {  // first cell after the place asked for
        const std::uint32_t middle = low + (high - low) / 2;
        if (std::tie(root, key) < std::tie(cells_[middle].root, keys_[middle]))
            high = middle;
        else
            low = middle + 1;
    }
    if (low == 0 || cells_[low - 1].root != root) return std::nullopt;
    return low - 1;
}

std::optional<std::uint32_t> QuadtreeView::find(HalfedgeId root, int level, LatticePoint at) const {
    const auto found = find_key(root, z_order(level, at));
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
        const auto found = find_key(p.root, z_order(c.level + finer, {square(p.x), square(p.y)}));
        if (!found) return {};
        if (result.count == 0 || result.cell[0] != *found) result.cell[result.count++] = *found;
    }
    return result;
}

}  // namespace tetrakis
