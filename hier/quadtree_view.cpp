#include "tetrakis/hier/quadtree_view.hpp"

#include "tetrakis/hier/parallel.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <tuple>

namespace tetrakis {

namespace {

/// Puts a zero before each bit of a number below 2^32.
std::uint64_t spread(std::uint64_t x) {
    x = (x | x << 16) & 0x0000'FFFF'0000'FFFFull;
    x = (x | x << 8) & 0x00FF'00FF'00FF'00FFull;
    x = (x | x << 4) & 0x0F0F'0F0F'0F0F'0F0Full;
    x = (x | x << 2) & 0x3333'3333'3333'3333ull;
    return (x | x << 1) & 0x5555'5555'5555'5555ull;
}

std::uint64_t z_order(int level, LatticePoint p) {
    const int shift = k_max_level - level;
    return spread(std::uint64_t{p.x} << shift) | spread(std::uint64_t{p.y} << shift) << 1;
}

/// Half a cell, covered by a leaf.
struct Half {
    std::uint64_t key;
    HalfedgeId root;
    LatticePoint at;
    LeafId leaf;
    std::uint8_t level, index;
    bool operator<(const Half& o) const { return std::tie(root, key, index) < std::tie(o.root, o.key, o.index); }
};

/// @param shape  of a triangle of odd depth: half a cell
Half half(LeafId leaf, HalfedgeId root, int depth, const BisectionShape& shape) {
    const LatticePoint a = shape.a(), b = shape.b(), p = shape.apex;
    const LatticePoint at{std::min({a.x, b.x, p.x}), std::min({a.y, b.y, p.y})};
    const std::uint8_t level = lattice_level(depth);
    // The two halves of a cell have their apices at opposite corners.
    return {z_order(level, at), root, at, leaf, level, static_cast<std::uint8_t>(shape.direction >= 4)};
}

}  // namespace

QuadtreeView::QuadtreeView(const BisectionForest& forest) : mesh_(&forest.mesh()) {
    std::vector<Half> halves;
    halves.reserve(forest.leaf_count() + forest.leaf_count() / 2);
    for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s) {
        const LeafId id(s);
        if (!forest.is_leaf(id)) continue;
        const BisectionLeaf& leaf = forest.leaf(id);
        if (leaf.depth % 2 != 0) {
            halves.push_back(half(id, leaf.cell, leaf.depth, leaf.shape()));
            continue;
        }
        for (int bit : {0, 1}) {
            const HalfedgeId cell = leaf.depth == 0 && bit == 1 ? mesh_->next(leaf.cell) : leaf.cell;
            halves.push_back(half(id, cell, leaf.depth + 1, leaf.shape().child(leaf.depth, bit)));
        }
    }
    oneapi::tbb::parallel_sort(halves.begin(), halves.end());
    const auto count = static_cast<std::uint32_t>(halves.size() / 2);
    keys_.resize(count);
    cells_.resize(count);
    for_each_index(count, [&](std::uint32_t i) {
        const Half &first = halves[2 * i], &second = halves[2 * i + 1];
        keys_[i] = first.key;
        cells_[i] = {first.root, first.at, first.level, {first.leaf, second.leaf}};
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
