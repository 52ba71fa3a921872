#pragma once

#include "../base/error.hpp"
#include "tree_forest.hpp"

#include <algorithm>
#include <cassert>
#include <string>
#include <utility>

// The parts of TreeForest that are compiled once for each rule.
namespace tetrakis {

namespace detail {

/// Takes the item that was freed last, or adds one.
template <class Items>
std::uint32_t take_free(std::vector<std::uint32_t>& free, Items& items) {
    if (free.empty()) {
        items.emplace_back();
        return static_cast<std::uint32_t>(items.size() - 1);
    }
    const std::uint32_t place = free.back();
    free.pop_back();
    return place;
}

}  // namespace detail

template <class Rule>
TreeForest<Rule>::TreeForest(Rule rule)
    : rule_(std::move(rule)), root_count_(rule_.root_count()), child_(root_count_, k_dead), marks_(root_count_, 0) {
    for (std::uint32_t root = 0; root < root_count_; ++root) {
        if (!rule_.has_root(root)) continue;
        child_[root] = k_unsplit;
        ++leaf_count_;
    }
}

template <class Rule>
std::uint64_t TreeForest<Rule>::path(LeafId leaf) const {
    std::uint64_t path = 0;
    int shift = 0;
    for (std::uint32_t slot = leaf.value; !is_root(slot); shift += 2) {
        path |= static_cast<std::uint64_t>(number(slot)) << shift;
        slot = records_[record_of(slot)].parent;
    }
    return path;
}

template <class Rule>
std::array<LeafId, 2> TreeForest<Rule>::neighbours(LeafId leaf, int side) const {
    const Across next = across(leaf.value, side);
    if (next.slot == k_boundary) return {};
    // The side is half of a side of the parent, whose neighbour across it is not split.
    if (next.slot == k_coarser) return {LeafId(across(records_[record_of(leaf.value)].parent, side).slot), LeafId{}};
    if (!is_split(next.slot)) return {LeafId(next.slot), LeafId{}};
    const std::uint32_t first = first_child(child_[next.slot]);
    return {LeafId(first + static_cast<std::uint32_t>(next_side(next.side))),
            LeafId(first + static_cast<std::uint32_t>(next.side))};
}

template <class Rule>
void TreeForest<Rule>::append_leaves(std::uint32_t slot, std::vector<LeafId>& leaves) const {
    if (child_[slot] == k_unsplit) leaves.emplace_back(slot);
    if (!is_split(slot)) return;
    for (std::uint32_t k = 0; k < 4; ++k) append_leaves(first_child(child_[slot]) + k, leaves);
}

template <class Rule>
std::vector<LeafId> TreeForest<Rule>::ordered_leaves() const {
    std::vector<LeafId> leaves;
    detail::reserve_large(leaves, leaf_count_);
    for (std::uint32_t root = 0; root < root_count_; ++root) append_leaves(root, leaves);
    return leaves;
}

template <class Rule>
std::uint64_t TreeForest<Rule>::memory_bytes() const {
    return rule_.memory_bytes() + records_.capacity() * sizeof(Record) + sites_.capacity() * sizeof(Site) +
           marks_.capacity() +
           (child_.capacity() + free_records_.capacity() + free_points_.capacity()) * sizeof(std::uint32_t);
}

template <class Rule>
void TreeForest<Rule>::shrink() {
    child_.shrink_to_fit();
    records_.shrink_to_fit();
    sites_.shrink_to_fit();
    free_records_.shrink_to_fit();
    free_points_.shrink_to_fit();
    marks_.shrink_to_fit();
}

// Refinement. During a call, marks_ is 1 for leaves to be split, and 2 for leaves that must not be reported as reshaped
// (any more).

// Lists the smallest closed set of splits that contains the marked leaves, in slot order, and sets marks_ for it. If
// there is no node of a leaf's level across a side, the parent's neighbour there must be split, too; so must the leaves
// on the other sides of creases.
template <class Rule>
void TreeForest<Rule>::mark_closure(std::span<const LeafId> marked, detail::PoolVector<std::uint32_t>& splits) {
    detail::reserve_large(splits, marked.size() + marked.size() / 4);
    const auto need = [&](std::uint32_t slot) {
        if (std::exchange(marks_[slot], std::uint8_t{1}) == 0) splits.push_back(slot);
    };
    for (const LeafId leaf : marked) need(leaf.value);
    for (std::size_t i = 0; i < splits.size(); ++i) {
        const std::uint32_t slot = splits[i];
        for_each_other_side(slot, need);
        for (int side = 0; side < k_sides; ++side)
            if (beyond(slot, side).slot == k_coarser) need(beyond(records_[record_of(slot)].parent, side).slot);
    }
    // Often a call splits all leaves, in their order.
    if (!std::is_sorted(splits.begin(), splits.end())) std::sort(splits.begin(), splits.end());
}

template <class Rule>
void TreeForest<Rule>::split(std::uint32_t slot, ForestChange& change) {
    const std::uint32_t record = detail::take_free(free_records_, records_);
    Record& r = records_[record];
    r.parent = slot;
    r.frame = frame(slot);
    if constexpr (Rule::k_midpoints) {
        const auto own = corners(slot);
        std::copy(own.begin(), own.end(), r.point.begin());
    }
    for (int side = 0; side < k_sides; ++side) {
        const Across next = beyond(slot, side);
        const bool both = next.slot < k_coarser && is_split(next.slot);
        r.link[side] = both ? 4 * child_[next.slot] + static_cast<std::uint32_t>(next.side)
                            : (next.slot == k_boundary ? k_boundary : k_coarser);
        if (both) records_[child_[next.slot]].link[next.side] = 4 * record + static_cast<std::uint32_t>(side);
        if constexpr (Rule::k_midpoints) {
            std::uint32_t& point = r.point[k_sides + side];
            if (both) {
                point = records_[child_[next.slot]].point[k_sides + next.side];
                continue;
            }
            point = detail::take_free(free_points_, sites_);
            sites_[point] = rule_.midpoint_site(r.frame, side);
            ++point_count_;
            if (next.slot >= k_coarser || marks_[next.slot] != 0) continue;
            marks_[next.slot] = 2;
            change.reshaped.emplace_back(next.slot);
        }
    }
    child_[slot] = record;
    for (std::uint32_t child = first_child(record); child < first_child(record) + 4; ++child) {
        if (child_.size() <= child) {
            child_.push_back(k_unsplit);
            marks_.push_back(2);
        }
        child_[child] = k_unsplit;
        marks_[child] = 2;
        change.created.emplace_back(child);
    }
    leaf_count_ += 3;
}

template <class Rule>
void TreeForest<Rule>::refine(std::span<const LeafId> marked, ForestChange& change) {
    for (const LeafId leaf : marked) {
        assert(is_leaf(leaf));
        if (level(leaf) >= k_max_level)
            throw Error(ErrorCode::unsupported, std::string(Rule::k_name) + " " + std::to_string(leaf.value) +
                                                    " is at level " + std::to_string(k_max_level) +
                                                    ", the deepest one");
    }
    detail::PoolVector<std::uint32_t> splits;
    try {
        mark_closure(marked, splits);
        const std::size_t count = splits.size();
        std::size_t points = 0;  // new points
        if constexpr (Rule::k_midpoints)
            for (const std::uint32_t slot : splits)
                for (int side = 0; side < k_sides; ++side) {
                    const std::uint32_t next = beyond(slot, side).slot;
                    points += next >= k_coarser || !(is_split(next) || (marks_[next] != 0 && next < slot)) ? 1 : 0;
                }
        const std::size_t records = records_.size() + count - std::min(count, free_records_.size());
        const std::size_t slots = root_count_ + 4 * records;
        const std::size_t sites = sites_.size() + points - std::min(points, free_points_.size());
        if (slots > k_max_slots || sites > k_max_slots)
            throw Error(ErrorCode::memory_limit, "the mesh would have more than 2^32 " + std::string(Rule::k_name) +
                                                     "s; use a looser tolerance");
        detail::make_room(records_, records);
        detail::make_room(child_, slots);
        detail::make_room(marks_, slots);
        detail::make_room(sites_, sites);
        change.created.clear();
        change.reshaped.clear();
        detail::reserve_large(change.created, 4 * count);
        change.reshaped.reserve(points);
    } catch (...) {
        std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
        throw;
    }
    // The rest does not throw.
    for (const std::uint32_t slot : splits) split(slot, change);
    for (const auto* const leaves : {&change.created, &change.reshaped})
        for (const LeafId leaf : *leaves) marks_[leaf.value] = 0;
    for (const std::uint32_t slot : splits) marks_[slot] = 0;
}

// Coarsening. While records are chosen, marks_ is set for the parent slots of records to be removed.

// Whether a split node beside a child of this node remains: it would be two levels finer than the merged node.
template <class Rule>
bool TreeForest<Rule>::has_finer_beside(const Record& record) const {
    for (int side = 0; side < k_sides; ++side) {
        const std::uint32_t link = record.link[side];
        if (link >= k_coarser || (creases(record) >> side & 1) != 0) continue;
        const int other = static_cast<int>(link % 4);
        for (const int child : {other, next_side(other)}) {
            const std::uint32_t slot = first_child(link / 4) + static_cast<std::uint32_t>(child);
            if (is_split(slot) && marks_[slot] == 0) return true;
        }
    }
    return false;
}

template <class Rule>
void TreeForest<Rule>::remove_records(std::span<const std::uint32_t> going, std::vector<LeafId>& reshaped) {
    const std::size_t points_before = free_points_.size();
    const auto is_going = [&](std::uint32_t slot) {
        return !is_root(slot) && marks_[records_[record_of(slot)].parent] != 0;
    };
    for (const std::uint32_t record : going) {
        const Record& r = records_[record];
        for (int side = 0; side < k_sides; ++side) {
            const std::uint32_t link = r.link[side];
            const bool alone = link >= k_coarser;
            const bool both_go = !alone && marks_[records_[link / 4].parent] != 0;
            if (!alone && !both_go) records_[link / 4].link[link % 4] = k_coarser;
            if constexpr (Rule::k_midpoints) {
                const std::uint32_t next = beyond(r.parent, side).slot;
                if (alone && next < k_coarser && !is_going(next)) reshaped.emplace_back(next);
                if (alone || (both_go && record < link / 4)) {
                    sites_[r.point[k_sides + side]] = Site{};
                    free_points_.push_back(r.point[k_sides + side]);
                }
            }
        }
    }
    for (const std::uint32_t record : going) {
        child_[records_[record].parent] = k_unsplit;
        marks_[records_[record].parent] = 0;
        std::fill_n(child_.begin() + first_child(record), 4, k_dead);
        free_records_.push_back(record);
    }
    point_count_ -= static_cast<std::uint32_t>(free_points_.size() - points_before);
    leaf_count_ -= static_cast<std::uint32_t>(3 * going.size());
}

template <class Rule>
std::vector<LeafId> TreeForest<Rule>::mergeable_siblings(LeafId leaf) const {
    if (!is_leaf(leaf) || is_root(leaf.value)) return {};
    std::vector<std::uint32_t> together{record_of(leaf.value)};
    for_each_other_side(records_[together.front()].parent,
                        [&](std::uint32_t slot) { together.push_back(child_[slot]); });
    std::vector<LeafId> siblings;
    for (const std::uint32_t record : together) {
        for (std::uint32_t k = 0; k < 4; ++k) {
            if (is_split(first_child(record) + k)) return {};
            siblings.emplace_back(first_child(record) + k);
        }
        if (has_finer_beside(records_[record])) return {};
    }
    return siblings;
}

template <class Rule>
void TreeForest<Rule>::coarsen(std::span<const LeafId> marked, ForestChange& change) {
    std::vector<std::uint32_t> slots, going;
    slots.reserve(marked.size());
    for (const LeafId leaf : marked) {
        assert(is_leaf(leaf));
        if (!is_root(leaf.value)) slots.push_back(leaf.value - root_count_);
    }
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    for (std::size_t i = 0; i + 3 < slots.size(); ++i)
        if (slots[i] % 4 == 0 && slots[i + 3] == slots[i] + 3) going.push_back(slots[i] / 4);
    if constexpr (Rule::k_midpoints) {
        detail::make_room(free_points_, free_points_.size() + k_sides * going.size());
        change.reshaped.reserve(k_sides * going.size());
    }
    detail::make_room(free_records_, free_records_.size() + going.size());
    change.created.reserve(going.size());

    for (const std::uint32_t record : going) marks_[records_[record].parent] = 1;
    // A group only stays because another one stays. So there is one largest set of groups that can be merged, whatever
    // the order.
    const auto stays = [&](std::uint32_t record) {
        const Record& r = records_[record];
        bool blocks = has_finer_beside(r);
        for (int side = 0; side < k_sides; ++side)
            if ((creases(r) >> side & 1) != 0 && marks_[records_[r.link[side] / 4].parent] == 0) blocks = true;
        if (blocks) marks_[r.parent] = 0;
        return blocks;
    };
    while (std::erase_if(going, stays) > 0) {
    }
    change.created.clear();
    change.reshaped.clear();
    for (const std::uint32_t record : going) change.created.emplace_back(records_[record].parent);
    remove_records(going, change.reshaped);
    std::sort(change.reshaped.begin(), change.reshaped.end());
    change.reshaped.erase(std::unique(change.reshaped.begin(), change.reshaped.end()), change.reshaped.end());
}

}  // namespace tetrakis
