#include "tetrakis/hier/bisection_forest.hpp"

#include "tetrakis/hier/corner_cell.hpp"
#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/huge_memory.hpp"
#include "tetrakis/hier/parallel.hpp"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <string>
#include <utility>

// A call splits a leaf up to three times: at its base, and then each child at its own, which is a leg of the leaf. So
// what a refinement does to a leaf is told by three bits, one per edge that gets a midpoint; a leg's bit implies the
// base's (closure), and every such edge is the base of the leaf on at least one side.
namespace tetrakis {

namespace {

constexpr std::uint8_t k_base = 1, k_leg1 = 2, k_leg2 = 4;  // edges to be bisected: 1 << edge
constexpr std::uint8_t k_listed = 8;                        // named by the caller

// Links that there is no need for: no neighbour, or nothing to be relinked.
constexpr std::uint8_t k_no_link = 3;

// Leaves per block of the parallel phases. The result does not depend on it.
constexpr std::uint32_t k_block = 512;

// Leaves whose records are asked for ahead of time: the phases wait for memory, for little else.
constexpr std::uint32_t k_ahead = 12;

bool one_thread() { return oneapi::tbb::this_task_arena::max_concurrency() == 1; }

std::uint32_t extra_leaves(std::uint8_t mark) { return 1u + (mark >> 1 & 1u) + (mark >> 2 & 1u); }

template <class T>
void prefetch(const T& where) {
    __builtin_prefetch(&where);
}

std::uint32_t fetch_min(std::uint32_t& number, std::uint32_t value) {
    std::atomic_ref ref(number);
    std::uint32_t before = ref.load(std::memory_order_relaxed);
    while (value < before && !ref.compare_exchange_weak(before, value, std::memory_order_relaxed)) {
    }
    return before;
}

}  // namespace

// Marks the bases of what the caller named and lists it, in order, without repetitions.
void BisectionForest::list_marked(std::span<const LeafId> marked) {
    auto& work = scratch_.work;
    auto& affected = scratch_.affected;
    const auto count = static_cast<std::uint32_t>(marked.size());
    const bool atomic = count > k_block && !one_thread();
    std::atomic<bool> repeated = false;
    detail::resize_large(affected, count);
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
            affected[i] = marked[i].value;
            std::uint8_t& mark = work[affected[i]].mark;
            const std::uint8_t before =
                atomic ? std::atomic_ref(mark).exchange(k_base | k_listed, std::memory_order_relaxed)
                       : std::exchange(mark, k_base | k_listed);
            if (before != 0) repeated.store(true, std::memory_order_relaxed);
        }
    });
    if (!repeated) return;
    for (std::uint32_t s : affected) work[s].mark = 0;
    std::erase_if(affected, [&](std::uint32_t s) { return std::exchange(work[s].mark, k_base | k_listed) != 0; });
}

// What close() reads first of the slots that come next in a list: their neighbours across the bases.
void BisectionForest::prefetch_bases(std::span<const std::uint32_t> slots, std::uint32_t i) const {
    if (i + 2 * k_ahead < slots.size()) prefetch(leaves_[slots[i + 2 * k_ahead]].neighbour);
    if (i + k_ahead >= slots.size()) return;
    const LeafId across = leaves_[slots[i + k_ahead]].neighbour[0];
    if (!across.valid()) return;
    prefetch(leaves_[across.value].neighbour);
    prefetch(scratch_.work[across.value]);
}

// Follows the base edges from each listed leaf to whatever has to be split with it, and puts that behind it in the
// list, unless an earlier leaf led there.
void BisectionForest::close() {
    auto& work = scratch_.work;
    auto& affected = scratch_.affected;
    if (affected.size() > k_block && !one_thread()) return close_in_parallel();
    std::vector<std::uint32_t> listed;
    detail::reserve_large(listed, affected.size() + affected.size() / 2);
    listed.swap(affected);
    const auto count = static_cast<std::uint32_t>(listed.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        prefetch_bases(listed, i);
        std::uint32_t slot = listed[i];
        affected.push_back(slot);
        for (;;) {
            const LeafId across = leaves_[slot].neighbour[0];
            work[slot].base_link = k_no_link;
            if (!across.valid()) break;
            const std::uint32_t edge = edge_towards(across.value, slot);
            work[slot].base_link = static_cast<std::uint8_t>(edge);
            Work& w = work[across.value];
            const std::uint8_t before = w.mark;
            w.mark = static_cast<std::uint8_t>(before | k_base | 1u << edge);
            if (before & k_base) break;  // it follows its own base, or did so
            affected.push_back(across.value);
            w.base_link = 0;
            if (edge == 0) break;
            slot = across.value;
        }
    }
}

// The same list: a leaf is claimed by the first listed one that leads there, whichever thread comes by first; when all
// claims are settled, each listed leaf collects its own. Links are written by all who pass, but all write the same.
void BisectionForest::close_in_parallel() {
    auto& work = scratch_.work;
    auto& affected = scratch_.affected;
    const auto count = static_cast<std::uint32_t>(affected.size());
    const auto set = [](std::uint8_t& byte, std::uint32_t value) {
        std::atomic_ref(byte).store(static_cast<std::uint8_t>(value), std::memory_order_relaxed);
    };
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
            prefetch_bases(affected, i);
            std::uint32_t slot = affected[i];
            for (;;) {
                const LeafId across = leaves_[slot].neighbour[0];
                if (!across.valid()) {
                    set(work[slot].base_link, k_no_link);
                    break;
                }
                const std::uint32_t edge = edge_towards(across.value, slot);
                set(work[slot].base_link, edge);
                Work& w = work[across.value];
                const std::uint8_t before = std::atomic_ref(w.mark).fetch_or(
                    static_cast<std::uint8_t>(k_base | 1u << edge), std::memory_order_relaxed);
                if ((before & k_listed) != 0 || fetch_min(w.first_leaf, i) <= i) break;
                if (edge == 0) {
                    set(w.base_link, 0);
                    break;
                }
                slot = across.value;
            }
        }
    });
    const std::uint32_t block_count = (count + k_block - 1) / k_block;
    std::vector<std::vector<std::uint32_t>> lists(block_count);
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            lists[b].reserve(2 * k_block);
            for (std::uint32_t i = b * k_block; i < std::min(count, (b + 1) * k_block); ++i) {
                prefetch_bases(affected, i);
                std::uint32_t slot = affected[i];
                lists[b].push_back(slot);
                for (;;) {
                    const LeafId across = leaves_[slot].neighbour[0];
                    if (!across.valid()) break;
                    const Work& w = work[across.value];
                    if ((w.mark & k_listed) != 0 || w.first_leaf != i) break;
                    lists[b].push_back(across.value);
                    if (work[slot].base_link == 0) break;
                    slot = across.value;
                }
            }
        },
        1);
    std::vector<std::size_t> first(block_count + 1, 0);
    for (std::uint32_t b = 0; b < block_count; ++b) first[b + 1] = first[b] + lists[b].size();
    affected.resize(first[block_count]);
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            std::copy(lists[b].begin(), lists[b].end(), affected.begin() + static_cast<std::ptrdiff_t>(first[b]));
        },
        1);
}

// Gives each affected leaf its places among the new leaves and points; returns their numbers.
std::array<std::uint32_t, 2> BisectionForest::plan_splits() {
    auto& work = scratch_.work;
    const auto& affected = scratch_.affected;
    const auto count = static_cast<std::uint32_t>(affected.size());
    const std::uint32_t block_count = (count + k_block - 1) / k_block;
    struct Sums {
        std::uint32_t leaves = 0, points = 0;
    };
    std::vector<Sums> sums(block_count + 1);
    const auto last = [&](std::uint32_t b) { return std::min(count, (b + 1) * k_block); };
    const auto add_up = [&](std::uint32_t b, Sums sum) {
        for (std::uint32_t i = b * k_block; i < last(b); ++i) {
            if (i + 2 * k_ahead < count) prefetch(leaves_[affected[i + 2 * k_ahead]].neighbour);
            if (i + k_ahead < count) {
                const LeafId leg = leaves_[affected[i + k_ahead]].neighbour[1];
                if (leg.valid()) prefetch(work[leg.value]);
            }
            const std::uint32_t slot = affected[i];
            const auto& across = leaves_[slot].neighbour;
            Work& w = work[slot];
            w.leg_link = k_no_link;
            if (!(w.mark & k_leg1) && across[1].valid() && work[across[1].value].mark == 0)
                w.leg_link = static_cast<std::uint8_t>(edge_towards(across[1].value, slot));
            w.first_leaf = sum.leaves;
            w.midpoint = sum.points;
            sum.leaves += extra_leaves(w.mark);
            // Of two leaves with one base edge the one in the lower slot makes the midpoint.
            sum.points += w.base_link != 0 || slot < across[0].value;
        }
        return sum;
    };
    std::uint64_t leaf_sum = 0, point_sum = 0;
    if (block_count <= 1 || one_thread()) {
        // At most three new leaves for each of less than 2^32: the sum may wrap, but a larger one is refused first.
        leaf_sum = std::uint64_t{3} * count;
        if (leaf_sum + leaves_.size() >= LeafId::none) {
            leaf_sum = 0;
            for (std::uint32_t s : affected) leaf_sum += extra_leaves(work[s].mark);
            reserve_for(leaf_sum, 0);
        }
        Sums sum;
        for (std::uint32_t b = 0; b < block_count; ++b) sum = add_up(b, sum);
        reserve_for(sum.leaves, sum.points);
        return {sum.leaves, sum.points};
    }
    for_each_index(
        block_count, [&](std::uint32_t b) { sums[b + 1] = add_up(b, {}); }, 1);
    leaf_sum = 0;
    for (Sums& s : sums) {
        leaf_sum += s.leaves;
        point_sum += s.points;
        s = {static_cast<std::uint32_t>(leaf_sum), static_cast<std::uint32_t>(point_sum)};
    }
    reserve_for(leaf_sum, point_sum);  // refuses sums that wrapped
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            if (b == 0) return;
            for (std::uint32_t i = b * k_block; i < last(b); ++i) {
                Work& w = work[affected[i]];
                w.first_leaf += sums[b].leaves;
                w.midpoint += sums[b].points;
            }
        },
        1);
    return {sums[block_count].leaves, sums[block_count].points};
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
        const std::uint32_t first = work[s].first_leaf, has01 = work[s].mark >> 2 & 1u;
        return {s, forest.new_leaf_slot(first), forest.new_leaf_slot(first + has01),
                forest.new_leaf_slot(first + has01 + 1)};
    }
    PointId midpoint(std::uint32_t slot) const { return PointId(forest.new_point_slot(work[slot].midpoint)); }

    // The descendants at the first and second half of a bisected edge of a split leaf, as it runs around the leaf.
    std::array<LeafId, 2> halves(std::uint32_t slot, std::uint32_t edge) const {
        // Chosen, not branched to: which edge it is cannot be foretold.
        const Slots n = slots(slot);
        const std::uint32_t base_first = work[slot].mark & k_leg2 ? n.s01 : n.s;
        const std::uint32_t leg_first = edge == 1 ? n.s1 : n.s, leg_second = edge == 1 ? n.s11 : n.s01;
        return {LeafId(edge == 0 ? base_first : leg_first), LeafId(edge == 0 ? n.s1 : leg_second)};
    }
    // The same as the leaf on the other side sees them: in reverse.
    std::array<LeafId, 2> halves_across(LeafId across, std::uint32_t edge) const {
        if (!across.valid()) return {};
        const auto [first, second] = halves(across.value, edge);
        return {second, first};
    }

    // For a leaf of the caller's own block: nobody else writes its record.
    void prefetch_neighbours(std::uint32_t slot) const {
        for (LeafId across : forest.leaves_[slot].neighbour)
            if (across.valid()) prefetch(work[across.value]);
    }

    void write(std::uint32_t slot, LeafId* created) const {
        const BisectionLeaf old = forest.leaves_[slot];
        const auto [first_leaf, midpoint_place, mark, base_link, leg_link] = work[slot];
        const Slots n = slots(slot);
        const auto [a, b, apex] = old.vertex;
        const auto [across0, across1, across2] = old.neighbour;

        const bool makes_point = base_link != 0 || slot < across0.value;
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
        const auto [first0, second0] = halves_across(across0, base_link);

        const auto depth1 = static_cast<std::uint8_t>(old.depth + 1), depth2 = static_cast<std::uint8_t>(old.depth + 2);
        const BisectionShape shape0 = old.shape().child(old.depth, 0), shape1 = old.shape().child(old.depth, 1);
        const HalfedgeId cell0 = old.cell, cell1 = old.depth == 0 ? forest.mesh_->next(old.cell) : old.cell;
        const std::uint64_t path0 = old.path << 1, path1 = path0 | 1;
        const LeafId slot0(slot), slot1(n.s1);
        // Child 0 and child 1 meet in the edge from the apex to m0.
        const LeafId beside0 = mark & k_leg1 ? LeafId(n.s11) : slot1;

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
        if (mark & k_leg2) {
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
        if (mark & k_leg1) {
            const LeafId slot11(n.s11);
            const PointId m1 = midpoint(across1.value);
            const auto [first1, second1] = halves_across(across1, 0);
            put(slot1, path1 << 1, cell1, shape1.child(depth1, 0), depth2, {second0, first1, slot11}, {m0, b, m1});
            put(slot11, path1 << 1 | 1, cell1, shape1.child(depth1, 1), depth2, {slot0, slot1, second1},
                {apex, m0, m1});
        } else {
            put(slot1, path1, cell1, shape1, depth1, {across1, slot0, second0}, {b, apex, m0});
            if (leg_link != k_no_link) forest.leaves_[across1.value].neighbour[leg_link] = slot1;
        }
    }
};

void BisectionForest::refine(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    for (std::size_t i = 0; i < marked.size(); ++i) {
        if (i + 2 * k_ahead < marked.size() && marked[i + 2 * k_ahead].value < leaves_.size())
            prefetch(leaves_[marked[i + 2 * k_ahead].value].depth);
        const LeafId id = marked[i];
        if (!is_leaf(id)) require_leaves({&id, 1});
        if (depth(id) >= k_max_bisection_depth)
            throw Error(ErrorCode::unsupported, "leaf " + std::to_string(id.value) + " is at the largest depth, " +
                                                    std::to_string(k_max_bisection_depth) +
                                                    "; the tolerance is out of reach here");
    }
    std::array<std::uint32_t, 2> news{};
    leaf_top_ = leaf_slots();
    point_top_ = point_slots();
    grow_work(leaf_top_);
    try {
        list_marked(marked);
        close();
        news = plan_splits();
        detail::resize_large(created, scratch_.affected.size() + news[0]);
    } catch (...) {
        clear_work();
        throw;
    }
    // From here on nothing throws: the room is reserved.
    const auto [new_leaves, new_points] = news;
    const auto reused_leaves = std::min<std::size_t>(new_leaves, free_leaves_.size());
    const auto reused_points = std::min<std::size_t>(new_points, free_points_.size());
    leaves_.resize(leaf_top_ + new_leaves - reused_leaves);
    sites_.resize(point_top_ + new_points - reused_points);
    auto& work = scratch_.work;
    const auto& affected = scratch_.affected;
    const SplitWriter writer{*this, work};
    const auto count = static_cast<std::uint32_t>(affected.size());
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
            if (i + 2 * k_ahead < end) prefetch(leaves_[affected[i + 2 * k_ahead]]);
            if (i + k_ahead < end) writer.prefetch_neighbours(affected[i + k_ahead]);
            const std::uint32_t slot = affected[i];
            writer.write(slot, created.data() + i + work[slot].first_leaf);
        }
    });
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
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
