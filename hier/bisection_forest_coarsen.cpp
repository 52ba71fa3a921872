#include "tetrakis/hier/bisection_forest.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/parallel.hpp"

#include <algorithm>
#include <string>

namespace tetrakis {

namespace {

constexpr std::uint8_t k_marked = 1;   // named by the caller
constexpr std::uint8_t k_merging = 2;  // all leaves of its diamond are

constexpr std::uint32_t k_block = 4096;

}  // namespace

// The leaves around a midpoint: pairs of siblings (child 0, child 1), two of them, or one at the boundary. The base of
// one pair's parent runs against the other's.
struct BisectionForest::Diamond {
    std::uint32_t pair_count = 0;
    std::array<std::array<std::uint32_t, 2>, 2> pairs{};

    template <class F>
    bool all(F&& f) const {
        for (std::uint32_t p = 0; p < pair_count; ++p)
            if (!f(pairs[p][0]) || !f(pairs[p][1])) return false;
        return true;
    }
    std::uint32_t lowest_slot() const {
        std::uint32_t lowest = LeafId::none;
        for (std::uint32_t p = 0; p < pair_count; ++p) lowest = std::min({lowest, pairs[p][0], pairs[p][1]});
        return lowest;
    }
};

// One parent that comes back: its record, and the link of an older leaf that pointed to the slot of child 1.
struct BisectionForest::Merge {
    BisectionLeaf parent;
    std::uint32_t freed_slot;
    std::uint32_t relinked_slot;
    std::uint32_t relinked_edge;
};

bool BisectionForest::find_diamond(std::uint32_t slot, Diamond& diamond) const {
    const std::uint8_t depth = leaves_[slot].depth;
    if (depth == 0) return false;
    // Where the neighbour beyond an inner edge of the diamond has the same depth, it is the diamond's own.
    const auto add_pair = [&](LeafId child0, LeafId child1) {
        if (!child0.valid() || !child1.valid()) return false;
        if (leaves_[child0.value].depth != depth || leaves_[child1.value].depth != depth) return false;
        if (leaves_[child0.value].neighbour[2] != child1) return false;
        diamond.pairs[diamond.pair_count++] = {child0.value, child1.value};
        return true;
    };
    diamond.pair_count = 0;
    const bool is_child1 = (leaves_[slot].path & 1) != 0;
    const LeafId child0 = is_child1 ? leaves_[slot].neighbour[1] : LeafId(slot);
    const LeafId child1 = is_child1 ? LeafId(slot) : leaves_[slot].neighbour[2];
    if (!add_pair(child0, child1)) return false;
    const LeafId other1 = leaves_[child0.value].neighbour[1], other0 = leaves_[child1.value].neighbour[2];
    return (!other0.valid() && !other1.valid()) || add_pair(other0, other1);
}

bool BisectionForest::can_merge(LeafId id) const {
    Diamond diamond;
    return is_leaf(id) && find_diamond(id.value, diamond);
}

LeafId BisectionForest::merge(LeafId id) {
    require_leaves({&id, 1});
    Diamond diamond;
    if (!find_diamond(id.value, diamond))
        throw Error(ErrorCode::invalid_input,
                    "leaf " + std::to_string(id.value) +
                        " cannot be merged: it is a root, or a leaf at its apex is split further");
    std::vector<LeafId> marked;
    for (std::uint32_t p = 0; p < diamond.pair_count; ++p)
        for (std::uint32_t s : diamond.pairs[p]) marked.push_back(LeafId(s));
    coarsen(marked, scratch_.created);
    return LeafId(diamond.pairs[0][0]);
}

std::size_t BisectionForest::coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    require_leaves(marked);
    grow_work(leaves_.size());
    auto& work = scratch_.work;
    std::vector<std::uint32_t> unique;
    std::vector<Diamond> diamonds;
    std::vector<Merge> merges;
    std::vector<std::uint32_t> points;
    const auto is_marked = [&](std::uint32_t s) { return work[s].mark != 0; };
    try {
        unique.reserve(marked.size());
        for (LeafId id : marked)
            if (std::exchange(work[id.value].mark, k_marked) == 0) unique.push_back(id.value);
        // Every leaf belongs to one diamond, that of its apex; the lowest slot speaks for it.
        const auto count = static_cast<std::uint32_t>(unique.size());
        std::vector<std::vector<Diamond>> found((count + k_block - 1) / k_block);
        for_each_index(
            static_cast<std::uint32_t>(found.size()),
            [&](std::uint32_t b) {
                Diamond diamond;
                for (std::uint32_t i = b * k_block; i < std::min(count, (b + 1) * k_block); ++i)
                    if (find_diamond(unique[i], diamond) && diamond.lowest_slot() == unique[i] &&
                        diamond.all(is_marked))
                        found[b].push_back(diamond);
            },
            1);
        std::size_t merge_count = 0;
        for (const auto& block : found) {
            diamonds.insert(diamonds.end(), block.begin(), block.end());
            for (const Diamond& d : block) merge_count += d.pair_count;
        }
        merges.resize(merge_count);
        created.resize(merge_count);
        free_leaves_.reserve(free_leaves_.size() + merge_count);
        free_points_.reserve(free_points_.size() + diamonds.size());
    } catch (...) {
        clear_work();
        throw;
    }
    for (const Diamond& d : diamonds) d.all([&](std::uint32_t s) { return (work[s].mark |= k_merging) != 0; });

    // Plan while all records are still whole.
    const auto merging = [&](std::uint32_t s) { return (work[s].mark & k_merging) != 0; };
    const auto after = [&](LeafId id) {
        const bool is_child1 = id.valid() && merging(id.value) && (leaves_[id.value].path & 1) != 0;
        return is_child1 ? leaves_[id.value].neighbour[1] : id;
    };
    std::size_t next = 0;
    for (const Diamond& d : diamonds)
        for (std::uint32_t p = 0; p < d.pair_count; ++p) {
            const auto [slot0, slot1] = d.pairs[p];
            const BisectionLeaf &child0 = leaves_[slot0], &child1 = leaves_[slot1];
            const BisectionShape shape = child0.shape().parent(child0.depth, 0);
            const LeafId beyond = child1.neighbour[0];  // across edge 1 of the parent
            Merge& m = merges[next++];
            m.parent = {.path = child0.path >> 1,
                        .cell = child0.cell,
                        .apex = shape.apex,
                        .neighbour = {d.pair_count == 2 ? LeafId(d.pairs[1 - p][0]) : LeafId{}, after(beyond),
                                      after(child0.neighbour[0])},
                        .vertex = {child0.vertex[1], child1.vertex[0], child0.vertex[0]},
                        .depth = static_cast<std::uint8_t>(child0.depth - 1),
                        .direction = shape.direction};
            m.freed_slot = slot1;
            // A merging neighbour beyond it has its base there and finds the new slot by after().
            const bool relink = beyond.valid() && !merging(beyond.value);
            m.relinked_slot = relink ? beyond.value : LeafId::none;
            m.relinked_edge = relink ? edge_towards(beyond.value, slot1) : 0;
        }

    next = 0;
    for (const Diamond& d : diamonds) {
        const PointId midpoint = leaves_[d.pairs[0][0]].vertex[2];
        for (std::uint32_t p = 0; p < d.pair_count; ++p) {
            const Merge& m = merges[next];
            leaves_[d.pairs[p][0]] = m.parent;
            leaves_[m.freed_slot].depth = k_dead;
            if (m.relinked_slot != LeafId::none)
                leaves_[m.relinked_slot].neighbour[m.relinked_edge] = LeafId(d.pairs[p][0]);
            free_leaves_.push_back(m.freed_slot);
            created[next++] = LeafId(d.pairs[p][0]);
        }
        sites_[midpoint.value] = Site{};
        free_points_.push_back(midpoint.value);
    }
    for (std::uint32_t s : unique) work[s].mark = 0;
    leaf_count_ -= static_cast<std::uint32_t>(merges.size());
    midpoint_count_ -= static_cast<std::uint32_t>(diamonds.size());
    return diamonds.size();
}

}  // namespace tetrakis
