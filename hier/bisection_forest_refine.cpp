#include "tetrakis/hier/bisection_forest.hpp"

#include "tetrakis/hier/corner_cell.hpp"
#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/parallel.hpp"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>

// A call splits a leaf up to three times: at its base, and then each child at its own, which is a leg of the leaf. So
// what a refinement does to a leaf is told by three bits, one per edge that gets a midpoint; a leg's bit implies the
// base's (closure), and every such edge is the base of the leaf on at least one side.
namespace tetrakis {

namespace {

constexpr std::uint8_t k_base = 1, k_leg1 = 2, k_leg2 = 4;  // edges to be bisected: 1 << edge
constexpr std::uint8_t k_listed = 8;                        // named by the caller

// Leaves per block of the parallel phases. Prefix sums make the result independent of it.
constexpr std::uint32_t k_block = 4096;

// Links of a leaf to be split, found while all records are still whole: the edge by which its base neighbour sees it
// (k_none without neighbour), and what edge of an unaffected neighbour across edge 1 has to follow it to a new slot.
constexpr std::uint8_t k_none = 3;
constexpr std::uint8_t pack_links(std::uint32_t base, std::uint32_t leg1) {
    return static_cast<std::uint8_t>(base | leg1 << 2);
}

bool one_thread() { return oneapi::tbb::this_task_arena::max_concurrency() == 1; }

std::uint8_t fetch_or(std::uint8_t& byte, std::uint8_t bits, bool atomic) {
    if (atomic) return std::atomic_ref(byte).fetch_or(bits, std::memory_order_relaxed);
    const std::uint8_t before = byte;
    byte |= bits;
    return before;
}

std::uint32_t extra_leaves(std::uint8_t mark) { return 1u + (mark >> 1 & 1u) + (mark >> 2 & 1u); }

}  // namespace

std::uint32_t BisectionForest::new_leaf_slot(std::uint32_t i) const {
    const auto reused = static_cast<std::uint32_t>(free_leaves_.size());
    return i < reused ? free_leaves_[reused - 1 - i] : leaf_top_ + (i - reused);
}

std::uint32_t BisectionForest::new_point_slot(std::uint32_t i) const {
    const auto reused = static_cast<std::uint32_t>(free_points_.size());
    return i < reused ? free_points_[reused - 1 - i] : point_top_ + (i - reused);
}

// Marks the bases of what the caller named and lists it, in order, without repetitions.
void BisectionForest::list_marked(std::span<const LeafId> marked) {
    auto& marks = scratch_.marks;
    auto& affected = scratch_.affected;
    const auto count = static_cast<std::uint32_t>(marked.size());
    const bool atomic = count > k_block && !one_thread();
    std::atomic<bool> repeated = false;
    affected.resize(count);
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
            affected[i] = marked[i].value;
            if (fetch_or(marks[affected[i]], k_base | k_listed, atomic) & k_listed)
                repeated.store(true, std::memory_order_relaxed);
        }
    });
    if (!repeated) return;
    for (std::uint32_t s : affected) marks[s] = 0;
    std::erase_if(affected, [&](std::uint32_t s) { return std::exchange(marks[s], k_base | k_listed) != 0; });
}

// Follows the base edges from all listed leaves, and appends what has to be split with them, in the order of slots.
void BisectionForest::close() {
    auto& marks = scratch_.marks;
    auto& affected = scratch_.affected;
    const auto count = static_cast<std::uint32_t>(affected.size());
    const bool atomic = count > k_block && !one_thread();
    std::vector<std::uint32_t> found;
    std::mutex found_mutex;
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        std::vector<std::uint32_t> own;
        for (std::uint32_t i = begin; i < end; ++i) {
            std::uint32_t slot = affected[i];
            for (;;) {
                const LeafId across = leaves_[slot].neighbour[0];
                if (!across.valid()) break;
                const std::uint32_t edge = edge_towards(across.value, slot);
                const std::uint8_t before =
                    fetch_or(marks[across.value], static_cast<std::uint8_t>(k_base | 1u << edge), atomic);
                if (before & k_base) break;  // whoever marked its base goes on from there
                own.push_back(across.value);
                if (edge == 0) break;
                slot = across.value;
            }
        }
        if (own.empty()) return;
        const std::lock_guard lock(found_mutex);
        found.insert(found.end(), own.begin(), own.end());
    });
    // Threads find them in any order. A scan of the marks costs less than sorting more than a few.
    constexpr std::uint32_t k_scan_factor = 64;
    if (found.size() < leaves_.size() / k_scan_factor) {
        std::sort(found.begin(), found.end());
    } else {
        found.clear();
        const auto slots = static_cast<std::uint32_t>(leaves_.size());
        for (std::uint32_t s = 0; s < slots; ++s)
            if ((marks[s] & (k_base | k_listed)) == k_base) found.push_back(s);
    }
    affected.insert(affected.end(), found.begin(), found.end());
}

// Gives each affected leaf its places among the new leaves and points; returns their numbers.
std::array<std::uint32_t, 2> BisectionForest::plan_splits() {
    const auto& marks = scratch_.marks;
    const auto& affected = scratch_.affected;
    auto& plans = scratch_.plans;
    const auto count = static_cast<std::uint32_t>(affected.size());
    plans.resize(leaves_.size());
    scratch_.links.resize(count);
    const std::uint32_t block_count = (count + k_block - 1) / k_block;
    std::vector<Plan> first(block_count + 1, Plan{0, 0});
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            std::uint32_t new_leaves = 0, new_points = 0;
            for (std::uint32_t i = b * k_block; i < std::min(count, (b + 1) * k_block); ++i) {
                const std::uint32_t slot = affected[i];
                const auto& across = leaves_[slot].neighbour;
                const std::uint8_t mark = marks[slot];
                std::uint32_t base = k_none, leg1 = k_none;
                if (across[0].valid()) base = edge_towards(across[0].value, slot);
                if (!(mark & k_leg1) && across[1].valid() && marks[across[1].value] == 0)
                    leg1 = edge_towards(across[1].value, slot);
                scratch_.links[i] = pack_links(base, leg1);
                // Of two leaves with one base edge the one in the lower slot makes the midpoint.
                const bool makes_point = base != 0 || slot < across[0].value;
                plans[slot] = {new_leaves, new_points};
                new_leaves += extra_leaves(mark);
                new_points += makes_point;
            }
            first[b + 1] = {new_leaves, new_points};
        },
        1);
    std::uint64_t leaf_sum = 0, point_sum = 0;
    for (Plan& p : first) {
        leaf_sum += p.first_leaf;
        point_sum += p.midpoint;
        if (leaf_sum >= LeafId::none || point_sum >= PointId::none) break;  // reserve_for() refuses such sums
        p = {static_cast<std::uint32_t>(leaf_sum), static_cast<std::uint32_t>(point_sum)};
    }
    reserve_for(leaf_sum, point_sum);
    for_each_index(
        block_count,
        [&](std::uint32_t b) {
            if (b == 0) return;
            for (std::uint32_t i = b * k_block; i < std::min(count, (b + 1) * k_block); ++i) {
                Plan& p = plans[affected[i]];
                p = {p.first_leaf + first[b].first_leaf, p.midpoint + first[b].midpoint};
            }
        },
        1);
    return {first[block_count].first_leaf, first[block_count].midpoint};
}

void BisectionForest::reserve_for(std::uint64_t new_leaves, std::uint64_t new_points) {
    const std::uint64_t slots = leaves_.size() + new_leaves - std::min<std::uint64_t>(new_leaves, free_leaves_.size());
    const std::uint64_t points = sites_.size() + new_points - std::min<std::uint64_t>(new_points, free_points_.size());
    if (slots >= LeafId::none || points >= PointId::none)
        throw Error(ErrorCode::memory_limit,
                    "the refinement would have more than 2^32 - 1 leaves; use a larger tolerance or a lower level");
    leaves_.reserve(slots);
    sites_.reserve(points);
    scratch_.marks.reserve(slots);
}

// The last phase: each affected leaf writes its descendants and its midpoint. It reads its own record and, of others,
// only marks and plans, which nobody writes; of its unaffected neighbours it writes the one link that is its own.
struct BisectionForest::SplitWriter {
    BisectionForest& forest;
    const detail::PodArray<std::uint8_t>& marks;
    const detail::PodArray<Plan>& plans;

    // Slots of the descendants of a split leaf; those that do not come about are garbage.
    struct Slots {
        std::uint32_t s, s01, s1, s11;
    };
    Slots slots(std::uint32_t s) const {
        const std::uint8_t mark = marks[s];
        const std::uint32_t first = plans[s].first_leaf, has01 = mark >> 2 & 1u;
        return {s, forest.new_leaf_slot(first), forest.new_leaf_slot(first + has01),
                forest.new_leaf_slot(first + has01 + 1)};
    }
    PointId midpoint(std::uint32_t slot) const { return PointId(forest.new_point_slot(plans[slot].midpoint)); }

    // The descendants at the first and second half of a bisected edge of a split leaf, as it runs around the leaf.
    std::array<LeafId, 2> halves(std::uint32_t slot, std::uint32_t edge) const {
        const Slots n = slots(slot);
        const std::uint8_t mark = marks[slot];
        switch (edge) {
            case 0:
                return {LeafId(mark & k_leg2 ? n.s01 : n.s), LeafId(n.s1)};
            case 1:
                return {LeafId(n.s1), LeafId(n.s11)};
            default:
                return {LeafId(n.s), LeafId(n.s01)};
        }
    }
    // The same as the leaf on the other side sees them: in reverse.
    std::array<LeafId, 2> halves_across(LeafId across, std::uint32_t edge) const {
        if (!across.valid()) return {};
        const auto [first, second] = halves(across.value, edge);
        return {second, first};
    }

    void write(std::uint32_t slot, std::uint8_t links, LeafId* created) const {
        const BisectionLeaf old = forest.leaves_[slot];
        const std::uint8_t mark = marks[slot];
        const Slots n = slots(slot);
        const std::uint32_t base_link = links & 3u, leg1_link = links >> 2;
        const auto [a, b, apex] = old.vertex;
        const auto [across0, across1, across2] = old.neighbour;

        const bool makes_point = base_link != 0 || slot < across0.value;
        const PointId m0 = midpoint(makes_point ? slot : across0.value);
        if (makes_point)
            forest.sites_[m0.value] =
                canonical(*forest.mesh_, {old.cell, old.shape().middle(old.depth), lattice_level(old.depth + 1)});
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
            forest.leaves_[at.value] = {path, cell, shape.apex, neighbour, vertex, depth, shape.direction};
            *created++ = at;
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
            if (beyond.valid() && marks[beyond.value] != 0) beyond = LeafId(slots(beyond.value).s1);
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
            if (leg1_link != k_none) forest.leaves_[across1.value].neighbour[leg1_link] = slot1;
        }
    }
};

void BisectionForest::refine(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    require_leaves(marked);
    for (LeafId id : marked)
        if (depth(id) >= k_max_bisection_depth)
            throw Error(ErrorCode::unsupported, "leaf " + std::to_string(id.value) + " is at the largest depth, " +
                                                    std::to_string(k_max_bisection_depth) +
                                                    "; the tolerance is out of reach here");
    std::uint32_t new_leaves = 0, new_points = 0;
    leaf_top_ = leaf_slots();
    point_top_ = point_slots();
    scratch_.marks.resize_zeroed(leaf_top_);
    try {
        list_marked(marked);
        close();
        const auto sums = plan_splits();
        new_leaves = sums[0];
        new_points = sums[1];
        created.resize(scratch_.affected.size() + new_leaves);
    } catch (...) {
        clear_all_marks();
        throw;
    }
    // From here on nothing throws: the room is reserved.
    const auto reused_leaves = std::min<std::size_t>(new_leaves, free_leaves_.size());
    const auto reused_points = std::min<std::size_t>(new_points, free_points_.size());
    leaves_.resize(leaf_top_ + new_leaves - reused_leaves);
    sites_.resize(point_top_ + new_points - reused_points);
    const SplitWriter writer{*this, scratch_.marks, scratch_.plans};
    const auto count = static_cast<std::uint32_t>(scratch_.affected.size());
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) {
            const std::uint32_t slot = scratch_.affected[i];
            writer.write(slot, scratch_.links[i], created.data() + i + scratch_.plans[slot].first_leaf);
        }
    });
    for_each_block(count, k_block, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t i = begin; i < end; ++i) scratch_.marks[scratch_.affected[i]] = 0;
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
