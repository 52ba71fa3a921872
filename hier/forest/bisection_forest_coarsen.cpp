#include "bisection_forest.hpp"

#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "../base/parallel.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

constexpr std::uint8_t k_marked = 1;   // named by the caller
constexpr std::uint8_t k_merging = 2;  // all leaves of its diamond are

constexpr std::uint32_t k_block = 4096;
constexpr std::uint32_t k_ahead = 12;  // leaves whose records are asked for ahead of time

/// Most records lie across the end of a cache line.
void prefetch_leaf(const BisectionLeaf& leaf) {
    __builtin_prefetch(&leaf);
    __builtin_prefetch(reinterpret_cast<const char*>(&leaf + 1) - 1);
}

}  // namespace

// The leaves around a midpoint: pairs of siblings (child 0, child 1), two of them, or one at the boundary. The base of
// one pair's parent runs against the other's.
struct BisectionForest::Diamond {
    std::uint32_t pair_count = 0;
    std::uint32_t first_merge = 0;  // its place among all pairs
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

std::array<LeafId, 2> BisectionForest::merge(LeafId id) {
    require_leaves({&id, 1});
    Diamond diamond;
    if (!find_diamond(id.value, diamond))
        throw Error(ErrorCode::invalid_input,
                    "leaf " + std::to_string(id.value) +
                        " cannot be merged: it is a root, or a leaf at its apex is split further");
    // The pair with the lowest slot comes first, as in coarsen().
    if (const std::uint32_t lowest = diamond.lowest_slot(); lowest != id.value) find_diamond(lowest, diamond);
    grow_work(leaves_.size());
    detail::make_room(free_leaves_, free_leaves_.size() + diamond.pair_count);
    detail::make_room(free_points_, free_points_.size() + 1);
    std::array<Merge, 2> merges;
    std::array<LeafId, 2> parents;
    merge_diamonds({&diamond, 1}, std::span(merges).first(diamond.pair_count),
                   std::span(parents).first(diamond.pair_count));
    diamond.all([&](std::uint32_t s) {
        scratch_.work[s].mark = 0;
        return true;
    });
    return parents;
}

std::size_t BisectionForest::coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    require_leaves(marked);
    grow_work(leaves_.size());
    auto& work = scratch_.work;
    detail::PoolVector<std::uint32_t> unique;
    detail::PoolVector<Diamond> diamonds;
    detail::PoolVector<Merge> merges;
    try {
        detail::reserve_large(unique, marked.size());
        for (std::size_t i = 0; i < marked.size(); ++i) {
            if (i + 2 * k_ahead < marked.size()) __builtin_prefetch(&work[marked[i + 2 * k_ahead].value], 1);
            if (std::exchange(work[marked[i].value].mark, k_marked) == 0) unique.push_back(marked[i].value);
        }
        detail::resize_large(merges, find_marked_diamonds(unique, diamonds));
        created.resize(merges.size());
        detail::make_room(free_leaves_, free_leaves_.size() + merges.size());
        detail::make_room(free_points_, free_points_.size() + diamonds.size());
    } catch (...) {
        clear_work();
        throw;
    }
    merge_diamonds(diamonds, merges, created);
    for (std::uint32_t s : unique) work[s].mark = 0;
    return diamonds.size();
}

// Merges diamonds of leaves. Their places in `merges` follow each other; there is room for what they free. Leaves their
// marks set. Does not throw.
void BisectionForest::merge_diamonds(std::span<const Diamond> diamonds, std::span<Merge> merges,
                                     std::span<LeafId> created) {
    auto& work = scratch_.work;
    const auto count = static_cast<std::uint32_t>(diamonds.size());
    for_each_index(count, [&](std::uint32_t i) {
        if (i + k_ahead < count)
            diamonds[i + k_ahead].all([&](std::uint32_t s) {
                __builtin_prefetch(&work[s], 1);
                return true;
            });
        diamonds[i].all([&](std::uint32_t s) { return (work[s].mark |= k_merging) != 0; });
    });
    // Plan while all records are still whole, then write.
    for_each_index(count, [&](std::uint32_t i) {
        if (i + 3 * k_ahead < count)
            diamonds[i + 3 * k_ahead].all([&](std::uint32_t s) {
                prefetch_leaf(leaves_[s]);
                return true;
            });
        if (i + k_ahead < count) prefetch_beyond(diamonds[i + k_ahead]);
        for (std::uint32_t p = 0; p < diamonds[i].pair_count; ++p)
            merges[diamonds[i].first_merge + p] = plan_merge(diamonds[i], p);
    });
    // Freed slots are used again from the end of the lists: put there backwards, they come in the order of their
    // parents again, and a forest that grows anew lies in memory as before (bench hierarchy/forest_operations).
    free_leaves_.resize(free_leaves_.size() + merges.size());
    free_points_.resize(free_points_.size() + diamonds.size());
    const std::size_t last_leaf = free_leaves_.size() - 1, last_point = free_points_.size() - 1;
    for_each_index(count, [&](std::uint32_t i) {
        if (i + k_ahead < count) {
            const Diamond& ahead = diamonds[i + k_ahead];
            for (std::uint32_t p = 0; p < ahead.pair_count; ++p) {
                const std::uint32_t relinked = merges[ahead.first_merge + p].relinked_slot;
                if (relinked != LeafId::none) __builtin_prefetch(&leaves_[relinked].neighbour, 1);
            }
            ahead.all([&](std::uint32_t s) {
                prefetch_leaf(leaves_[s]);
                return true;
            });
        }
        const Diamond& d = diamonds[i];
        const PointId midpoint = leaves_[d.pairs[0][0]].vertex[2];
        for (std::uint32_t p = 0; p < d.pair_count; ++p) {
            const Merge& m = merges[d.first_merge + p];
            const LeafId parent(d.pairs[p][0]);
            leaves_[parent.value] = m.parent;
            leaves_[m.freed_slot].depth = k_dead;
            if (m.relinked_slot != LeafId::none) leaves_[m.relinked_slot].neighbour[m.relinked_edge] = parent;
            free_leaves_[last_leaf - d.first_merge - p] = m.freed_slot;
            created[d.first_merge + p] = parent;
        }
        sites_[midpoint.value] = Site{};
        free_points_[last_point - i] = midpoint.value;
    });
    leaf_count_ -= static_cast<std::uint32_t>(merges.size());
    midpoint_count_ -= count;
}

// Diamonds whose leaves are all marked, in the order of their lowest slots in `unique`. Returns the number of pairs.
std::size_t BisectionForest::find_marked_diamonds(std::span<const std::uint32_t> unique,
                                                  detail::PoolVector<Diamond>& diamonds) const {
    const auto count = static_cast<std::uint32_t>(unique.size());
    const auto is_marked = [&](std::uint32_t s) { return scratch_.work[s].mark != 0; };
    // Across its legs are the diamond's leaves, if there is one: a leaf that is not the lowest mostly sees so itself.
    const auto may_be_lowest = [&](std::uint32_t s) {
        const auto& across = leaves_[s].neighbour;
        return s < across[1].value && s < across[2].value;
    };
    std::vector<detail::PoolVector<Diamond>> found((count + k_block - 1) / k_block);
    for_each_index(
        static_cast<std::uint32_t>(found.size()),
        [&](std::uint32_t b) {
            Diamond diamond;
            for (std::uint32_t i = b * k_block; i < std::min(count, (b + 1) * k_block); ++i) {
                if (i + 2 * k_ahead < count) prefetch_leaf(leaves_[unique[i + 2 * k_ahead]]);
                if (i + k_ahead < count && may_be_lowest(unique[i + k_ahead]))
                    for (const std::size_t leg : {1, 2})
                        if (const LeafId across = leaves_[unique[i + k_ahead]].neighbour[leg]; across.valid()) {
                            prefetch_leaf(leaves_[across.value]);
                            __builtin_prefetch(&scratch_.work[across.value]);
                        }
                // Every leaf belongs to one diamond, that of its apex; the lowest slot speaks for it.
                if (may_be_lowest(unique[i]) && find_diamond(unique[i], diamond) &&
                    diamond.lowest_slot() == unique[i] && diamond.all(is_marked))
                    found[b].push_back(diamond);
            }
        },
        1);
    std::size_t merge_count = 0, diamond_count = 0;
    for (const auto& block : found) diamond_count += block.size();
    detail::reserve_large(diamonds, diamond_count);
    for (auto& block : found)
        for (Diamond& d : block) {
            d.first_merge = static_cast<std::uint32_t>(merge_count);
            merge_count += d.pair_count;
            diamonds.push_back(d);
        }
    return merge_count;
}

void BisectionForest::prefetch_beyond(const Diamond& diamond) const {
    diamond.all([&](std::uint32_t s) {
        const LeafId beyond = leaves_[s].neighbour[0];
        if (!beyond.valid()) return true;
        __builtin_prefetch(&scratch_.work[beyond.value]);
        prefetch_leaf(leaves_[beyond.value]);
        return true;
    });
}

BisectionForest::Merge BisectionForest::plan_merge(const Diamond& d, std::uint32_t pair) const {
    const auto merging = [&](LeafId id) { return (scratch_.work[id.value].mark & k_merging) != 0; };
    const auto after = [&](LeafId id) {
        const bool is_child1 = id.valid() && merging(id) && (leaves_[id.value].path & 1) != 0;
        return is_child1 ? leaves_[id.value].neighbour[1] : id;
    };
    const auto [slot0, slot1] = d.pairs[pair];
    const BisectionLeaf &child0 = leaves_[slot0], &child1 = leaves_[slot1];
    const BisectionShape shape = child0.shape().parent(child0.depth, 0);
    const LeafId beyond = child1.neighbour[0];  // across edge 1 of the parent
    // A merging neighbour beyond it has its base there and finds the new slot by after().
    const bool relink = beyond.valid() && !merging(beyond);
    return {.parent = {.path = child0.path >> 1,
                       .cell = child0.cell,
                       .apex = shape.apex,
                       .neighbour = {d.pair_count == 2 ? LeafId(d.pairs[1 - pair][0]) : LeafId{}, after(beyond),
                                     after(child0.neighbour[0])},
                       .vertex = {child0.vertex[1], child1.vertex[0], child0.vertex[0]},
                       .depth = static_cast<std::uint8_t>(child0.depth - 1),
                       .direction = shape.direction},
            .freed_slot = slot1,
            .relinked_slot = relink ? beyond.value : LeafId::none,
            .relinked_edge = relink ? edge_towards(beyond.value, slot1) : 0};
}

}  // namespace tetrakis
