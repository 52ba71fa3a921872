#include "bisection_forest.hpp"

#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "../base/parallel.hpp"
#include "corner_cell.hpp"

#include <algorithm>
#include <atomic>
#include <string>
#include <type_traits>
#include <utility>

// A call splits a leaf up to three times: at its base, and then each child at its own, which is a leg of the leaf. So
// what a refinement does to a leaf is told by three bits, one per edge that gets a midpoint; a leg's bit implies the
// base's (closure), and every such edge is the base of the leaf on at least one side.
namespace tetrakis {

namespace {

// Why a leaf is split.
constexpr std::uint8_t k_closure = 1, k_listed = 2;

// Of Work::base: the edge by which the neighbour across the base sees the leaf, and whether the leaf is the one of the
// two that makes the midpoint, the one in the lower slot where both are split at this edge.
constexpr std::uint8_t k_link = 3, k_makes_point = 4;

constexpr std::uint8_t split_base(std::uint32_t link, std::uint32_t slot, std::uint32_t across) {
    return static_cast<std::uint8_t>(link | (link != 0 || slot < across ? k_makes_point : 0));
}
// Without a neighbour across the base.
constexpr std::uint8_t k_boundary_base = k_link | k_makes_point;

// Leaves per block of the parallel phases. The result does not depend on it.
constexpr std::uint32_t k_block = 512;

// Marks below which one thread is not slower: each phase wakes the others up.
constexpr std::uint32_t k_few = 4096;

// Leaves whose records are asked for ahead of time: the phases wait for memory, for little else.
constexpr std::uint32_t k_ahead = 12;

template <class T>
void prefetch(const T& where) {
    __builtin_prefetch(&where);
}

template <class T>
T load(T& shared) {
    return std::atomic_ref(shared).load(std::memory_order_relaxed);
}
template <class T>
void store(T& shared, std::type_identity_t<T> value) {
    std::atomic_ref(shared).store(value, std::memory_order_relaxed);
}
std::uint32_t fetch_min(std::uint32_t& number, std::uint32_t value) {
    std::atomic_ref ref(number);
    std::uint32_t before = ref.load(std::memory_order_relaxed);
    while (value < before && !ref.compare_exchange_weak(before, value, std::memory_order_relaxed)) {
    }
    return before;
}

}  // namespace

// Numbers of new leaves and points.
struct BisectionForest::SplitSums {
    std::uint64_t leaves = 0, points = 0;
    void add(const Work& w) {
        leaves += 1u + w.leg[0] + w.leg[1];
        points += w.base >= k_makes_point;
    }
    // Gives a leaf its places, which come after those counted so far. Sums that wrap are refused in the end.
    void place(Work& w) {
        w.first_leaf = static_cast<std::uint32_t>(leaves);
        w.midpoint = static_cast<std::uint32_t>(points);
        add(w);
    }
};

// Marks what the caller named and lists it, in order; with repetitions if `parallel`, for claim_bases() to find.
void BisectionForest::list_marked(std::span<const LeafId> marked, bool parallel) {
    auto& [work, listed, affected, created] = scratch_;
    const auto count = static_cast<std::uint32_t>(marked.size());
    const auto prefetch_marked = [&](std::uint32_t i) {
        if (i + 2 * k_ahead < count && marked[i + 2 * k_ahead].value < leaf_top_)
            prefetch(work[marked[i + 2 * k_ahead].value]);
    };
    listed.resize(count);
    if (parallel) {
        std::uint32_t first_refused = count;
        for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t i = begin; i < end; ++i) {
                prefetch_marked(i);
                listed[i] = marked[i].value;
                if (listed[i] >= leaf_top_) {
                    fetch_min(first_refused, i);
                    continue;
                }
                store(work[listed[i]].mark, k_listed);
                store(work[listed[i]].first_leaf, i);
            }
        });
        // One before it may be no leaf either.
        if (first_refused < count)
            for (std::uint32_t i = 0; i <= first_refused; ++i) require_splittable(marked[i]);
        return;
    }
    std::uint32_t unique = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        prefetch_marked(i);
        if (marked[i].value >= leaf_top_)
            for (std::uint32_t k = 0; k <= i; ++k) require_splittable(marked[k]);
        listed[unique] = marked[i].value;
        Work& w = work[marked[i].value];
        if (std::exchange(w.mark, k_listed) == 0) w.first_leaf = unique++;
    }
    listed.resize(unique);
}

void BisectionForest::require_splittable(LeafId id) const {
    if (is_splittable(id)) return;
    require_leaves({&id, 1});
    throw Error(ErrorCode::unsupported, "leaf " + std::to_string(id.value) + " is at the largest depth, " +
                                            std::to_string(k_max_bisection_depth) +
                                            "; the tolerance is out of reach here");
}

// What the closure reads first of the slots that come next in the list: their neighbours across the bases.
void BisectionForest::prefetch_bases(std::uint32_t i) const {
    const auto& slots = scratch_.listed;
    if (i + 2 * k_ahead < slots.size()) {
        prefetch(leaves_[slots[i + 2 * k_ahead]].neighbour);
        prefetch(leaves_[slots[i + 2 * k_ahead]].depth);
    }
    if (i + k_ahead >= slots.size()) return;
    const LeafId across = leaves_[slots[i + k_ahead]].neighbour[0];
    if (!across.valid()) return;
    prefetch(leaves_[across.value].neighbour);
    prefetch(scratch_.work[across.value]);
}

// Follows the base edges from each listed leaf to whatever has to be split with it, and lists that behind it among the
// affected leaves, unless an earlier leaf led there. Then gives each its places among the new leaves and points.
BisectionForest::SplitSums BisectionForest::plan_serially() {
    auto& [work, listed, affected, created] = scratch_;
    const auto count = static_cast<std::uint32_t>(listed.size());
    affected.resize(0);
    affected.reserve(count + count / 2);
    for (std::uint32_t i = 0; i < count; ++i) {
        prefetch_bases(i);
        std::uint32_t slot = listed[i];
        require_splittable(LeafId(slot));
        affected.push_back(slot);
        for (;;) {
            const LeafId across = leaves_[slot].neighbour[0];
            work[slot].base = k_boundary_base;
            if (!across.valid()) break;
            const std::uint32_t edge = edge_towards(across.value, slot);
            work[slot].base = split_base(edge, slot, across.value);
            Work& w = work[across.value];
            if (edge != 0) w.leg[edge - 1] = 1;
            if (w.mark != 0) break;  // it follows its own base, or did so
            w.mark = k_closure;
            affected.push_back(across.value);
            w.base = split_base(0, across.value, slot);
            if (edge == 0) break;
            slot = across.value;
        }
    }
    SplitSums sums;
    for (std::size_t i = 0; i < affected.size(); ++i) {
        if (i + k_ahead < affected.size()) prefetch(work[affected[i + k_ahead]]);
        sums.place(work[affected[i]]);
    }
    return sums;
}

// The first half of the closure: a leaf is claimed by the first listed one that leads there, whichever thread comes by
// first. All else that is written is the same whoever passes. Returns false if leaves were named repeatedly.
bool BisectionForest::claim_bases() {
    auto& [work, listed, affected, created] = scratch_;
    const auto count = static_cast<std::uint32_t>(listed.size());
    bool repeated = false;
    std::uint32_t first_refused = count;
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
            prefetch_bases(i);
            std::uint32_t slot = listed[i];
            if (work[slot].first_leaf != i) store(repeated, true);
            if (!is_splittable(LeafId(slot))) {
                fetch_min(first_refused, i);
                continue;
            }
            for (;;) {
                const LeafId across = leaves_[slot].neighbour[0];
                if (!across.valid()) {
                    store(work[slot].base, k_boundary_base);
                    break;
                }
                const std::uint32_t edge = edge_towards(across.value, slot);
                store(work[slot].base, split_base(edge, slot, across.value));
                Work& w = work[across.value];
                if (edge != 0) store(w.leg[edge - 1], 1);
                if (load(w.mark) == k_listed) break;
                store(w.mark, k_closure);
                if (fetch_min(w.first_leaf, i) <= i) break;
                if (edge == 0) {
                    store(w.base, split_base(0, across.value, slot));
                    break;
                }
                slot = across.value;
            }
        }
    });
    if (first_refused < count) require_splittable(LeafId(listed[first_refused]));
    return !repeated;
}

// The same as plan_serially().
BisectionForest::SplitSums BisectionForest::plan_in_parallel(std::span<const LeafId> marked) {
    auto& [work, listed, affected, created] = scratch_;
    if (!claim_bases()) {
        clear_work();
        list_marked(marked, false);
        claim_bases();
    }
    // Each listed leaf collects what it has claimed.
    const auto count = static_cast<std::uint32_t>(listed.size());
    const std::uint32_t block_count = (count + k_block - 1) / k_block;
    struct Block {
        std::vector<std::uint32_t> slots;
        std::size_t first = 0;
        SplitSums sums;
    };
    std::vector<Block> blocks(block_count);
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            Block& block = blocks[b];
            block.slots.reserve(2 * k_block);
            for (std::uint32_t i = b * k_block; i < std::min(count, (b + 1) * k_block); ++i) {
                prefetch_bases(i);
                std::uint32_t slot = listed[i];
                for (;;) {
                    block.slots.push_back(slot);
                    block.sums.add(work[slot]);
                    const LeafId across = leaves_[slot].neighbour[0];
                    if (!across.valid()) break;
                    const Work& w = work[across.value];
                    if (w.mark == k_listed || w.first_leaf != i) break;
                    if ((work[slot].base & k_link) == 0) {
                        block.slots.push_back(across.value);
                        block.sums.add(w);
                        break;
                    }
                    slot = across.value;
                }
            }
        },
        1);
    SplitSums sums;
    std::size_t first = 0;
    for (Block& block : blocks) {
        block.first = std::exchange(first, first + block.slots.size());
        const SplitSums own = std::exchange(block.sums, sums);
        sums.leaves += own.leaves;
        sums.points += own.points;
    }
    affected.resize(first);
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            Block& block = blocks[b];
            std::copy(block.slots.begin(), block.slots.end(), affected.data() + block.first);
            for (std::uint32_t slot : block.slots) block.sums.place(work[slot]);
        },
        1);
    return sums;
}

void BisectionForest::reserve_for(std::uint64_t new_leaves, std::uint64_t new_points) {
    const std::uint64_t slots = leaves_.size() + new_leaves - std::min<std::uint64_t>(new_leaves, free_leaves_.size());
    const std::uint64_t points = sites_.size() + new_points - std::min<std::uint64_t>(new_points, free_points_.size());
    if (slots >= LeafId::none || points >= PointId::none)
        throw Error(ErrorCode::memory_limit,
                    "the refinement would have more than 2^32 - 1 leaves; use a larger tolerance or a lower level");
    leaves_.reserve(slots);
    sites_.reserve(points);
}

// The last phase: each affected leaf writes its descendants and its midpoint. It reads its own record and, of others,
// only marks and plans, which nobody writes; of its unaffected neighbours it writes the one link that is its own.
struct BisectionForest::SplitWriter {
    BisectionForest& forest;
    const detail::PodArray<Work>& work;

    // Slots of the descendants of a split leaf; those that do not come about are garbage.
    struct Slots {
        std::uint32_t s, s01, s1, s11;
    };
    Slots slots(std::uint32_t s) const {
        const std::uint32_t first = work[s].first_leaf, has01 = work[s].leg[1];
        return {s, forest.new_leaf_slot(first), forest.new_leaf_slot(first + has01),
                forest.new_leaf_slot(first + has01 + 1)};
    }
    PointId midpoint(std::uint32_t slot) const { return PointId(forest.new_point_slot(work[slot].midpoint)); }

    // The descendants at the first and second half of a bisected edge of a split leaf, as it runs around the leaf.
    std::array<LeafId, 2> halves(std::uint32_t slot, std::uint32_t edge) const {
        // Chosen, not branched to: which edge it is cannot be foretold.
        const Slots n = slots(slot);
        const std::uint32_t base_first = work[slot].leg[1] != 0 ? n.s01 : n.s;
        const std::uint32_t leg_first = edge == 1 ? n.s1 : n.s, leg_second = edge == 1 ? n.s11 : n.s01;
        return {LeafId(edge == 0 ? base_first : leg_first), LeafId(edge == 0 ? n.s1 : leg_second)};
    }
    // The same as the leaf on the other side sees them: in reverse.
    std::array<LeafId, 2> halves_across(LeafId across, std::uint32_t edge) const {
        if (!across.valid()) return {};
        const auto [first, second] = halves(across.value, edge);
        return {second, first};
    }

    // In the record of an unaffected leaf, of whose links several leaves may write one each.
    void relink(std::uint32_t unaffected, std::uint32_t from, LeafId to) const {
        auto& n = forest.leaves_[unaffected].neighbour;
        std::size_t edge = 0;
        while (edge < 2 && load(n[edge].value) != from) ++edge;
        store(n[edge].value, to.value);
    }

    // For a leaf of the caller's own block: nobody else writes its record.
    void prefetch_neighbours(std::uint32_t slot) const {
        for (LeafId across : forest.leaves_[slot].neighbour)
            if (across.valid()) prefetch(work[across.value]);
    }

    void write(std::uint32_t slot, LeafId* created) const {
        const BisectionLeaf old = forest.leaves_[slot];
        const auto [first_leaf, midpoint_place, mark, base, leg] = work[slot];
        const Slots n = slots(slot);
        const auto [a, b, apex] = old.vertex;
        const auto [across0, across1, across2] = old.neighbour;

        const bool makes_point = base >= k_makes_point;
        const PointId m0 = midpoint(makes_point ? slot : across0.value);
        if (makes_point) {
            const auto [root, at, level] =
                canonical(*forest.mesh_, {old.cell, old.shape().middle(old.depth), lattice_level(old.depth + 1)});
            Site& site = forest.sites_[m0.value];
            site.root.value = root.value;
            site.at.x = at.x;
            site.at.y = at.y;
            site.level = level;
        }
        const auto [first0, second0] = halves_across(across0, base & k_link);

        const auto depth1 = static_cast<std::uint8_t>(old.depth + 1), depth2 = static_cast<std::uint8_t>(old.depth + 2);
        const BisectionShape shape0 = old.shape().child(old.depth, 0), shape1 = old.shape().child(old.depth, 1);
        const HalfedgeId cell0 = old.cell, cell1 = old.depth == 0 ? forest.mesh_->next(old.cell) : old.cell;
        const std::uint64_t path0 = old.path << 1, path1 = path0 | 1;
        const LeafId slot0(slot), slot1(n.s1);
        // Child 0 and child 1 meet in the edge from the apex to m0.
        const LeafId beside0 = leg[0] != 0 ? LeafId(n.s11) : slot1;

        const auto put = [&](LeafId at, std::uint64_t path, HalfedgeId cell, const BisectionShape& shape,
                             std::uint8_t depth, const std::array<LeafId, 3>& neighbour,
                             const std::array<PointId, 3>& vertex) {
            // Field by field: a record put together elsewhere and copied in larger pieces waits for its own stores.
            BisectionLeaf& leaf = forest.leaves_[at.value];
            leaf.path = path;
            leaf.cell = cell;
            leaf.apex.x = shape.apex.x;
            leaf.apex.y = shape.apex.y;
            for (std::size_t k = 0; k < 3; ++k) leaf.neighbour[k].value = neighbour[k].value;
            for (std::size_t k = 0; k < 3; ++k) leaf.vertex[k].value = vertex[k].value;
            leaf.depth = depth;
            leaf.direction = shape.direction;
            created->value = at.value;
            ++created;
        };
        if (leg[1] != 0) {
            const LeafId slot01(n.s01);
            const PointId m2 = midpoint(across2.value);
            const auto [first2, second2] = halves_across(across2, 0);
            put(slot0, path0 << 1, cell0, shape0.child(depth1, 0), depth2, {beside0, first2, slot01}, {m0, apex, m2});
            put(slot01, path0 << 1 | 1, cell0, shape0.child(depth1, 1), depth2, {first0, slot0, second2}, {a, m0, m2});
        } else {
            // A split neighbour across an unsplit leg sees it as a leg, too; edges 1 and 2 always meet each other.
            LeafId beyond = across2;
            if (beyond.valid() && work[beyond.value].mark != 0) beyond = LeafId(slots(beyond.value).s1);
            put(slot0, path0, cell0, shape0, depth1, {beyond, first0, beside0}, {apex, a, m0});
        }
        if (leg[0] != 0) {
            const LeafId slot11(n.s11);
            const PointId m1 = midpoint(across1.value);
            const auto [first1, second1] = halves_across(across1, 0);
            put(slot1, path1 << 1, cell1, shape1.child(depth1, 0), depth2, {second0, first1, slot11}, {m0, b, m1});
            put(slot11, path1 << 1 | 1, cell1, shape1.child(depth1, 1), depth2, {slot0, slot1, second1},
                {apex, m0, m1});
        } else {
            put(slot1, path1, cell1, shape1, depth1, {across1, slot0, second0}, {b, apex, m0});
            if (across1.valid() && work[across1.value].mark == 0) relink(across1.value, slot, slot1);
        }
    }
};

void BisectionForest::refine(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    leaf_top_ = leaf_slots();
    point_top_ = point_slots();
    grow_work(leaf_top_);
    auto& [work, listed, affected, own_created] = scratch_;
    const bool parallel = marked.size() > k_few && !detail::one_thread();
    // What is refused is found while it is looked at anyway, and then all marks are cleared. A few are looked at first.
    if (marked.size() <= k_block)
        for (LeafId id : marked) require_splittable(id);
    SplitSums sums;
    try {
        list_marked(marked, parallel);
        sums = parallel ? plan_in_parallel(marked) : plan_serially();
        reserve_for(sums.leaves, sums.points);
        detail::resize_large(created, affected.size() + static_cast<std::size_t>(sums.leaves));
    } catch (...) {
        clear_work();
        throw;
    }
    // From here on nothing throws: the room is reserved.
    const auto new_leaves = static_cast<std::uint32_t>(sums.leaves);
    const auto new_points = static_cast<std::uint32_t>(sums.points);
    const auto reused_leaves = std::min<std::size_t>(new_leaves, free_leaves_.size());
    const auto reused_points = std::min<std::size_t>(new_points, free_points_.size());
    leaves_.resize(leaf_top_ + new_leaves - reused_leaves);
    sites_.resize(point_top_ + new_points - reused_points);
    const SplitWriter writer{*this, work};
    const auto count = static_cast<std::uint32_t>(affected.size());
    const std::uint32_t block = count > k_few ? k_block : k_few;
    for_each_block(count, block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
            if (i + 2 * k_ahead < end) prefetch(leaves_[affected[i + 2 * k_ahead]]);
            if (i + k_ahead < end) writer.prefetch_neighbours(affected[i + k_ahead]);
            const std::uint32_t slot = affected[i];
            writer.write(slot, created.data() + i + work[slot].first_leaf);
        }
    });
    // Writing all in a row is as good as jumping to some.
    constexpr std::uint32_t k_some = 8;
    if (count > leaf_top_ / k_some)
        for_each_block(
            static_cast<std::uint32_t>(work.size()), k_some * k_block,
            [&](std::uint32_t begin, std::uint32_t end) { std::fill(work.data() + begin, work.data() + end, Work{}); });
    else
        for_each_block(count, block, [&](std::uint32_t begin, std::uint32_t end) {
            for (std::uint32_t i = begin; i < end; ++i) work[affected[i]] = Work{};
        });
    free_leaves_.resize(free_leaves_.size() - reused_leaves);
    free_points_.resize(free_points_.size() - reused_points);
    leaf_count_ += new_leaves;
    midpoint_count_ += new_points;
}

std::size_t BisectionForest::split(LeafId id) {
    refine({&id, 1}, scratch_.created);
    return scratch_.created.size();
}

}  // namespace tetrakis
