#pragma once

#include "../base/error.hpp"
#include "../base/parallel.hpp"
#include "tree_forest.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <utility>

// The parts of TreeForest that are compiled once for each rule.
namespace tetrakis {

namespace detail {

// Some ten microseconds of closure or record writing: more than it costs to hand a block to a thread.
inline constexpr std::uint32_t k_split_grain = 256;

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
    // The side is half of one of the parent's, whose neighbour across is not split.
    if (next.slot == k_coarser) return {LeafId(across(records_[record_of(leaf.value)].parent, side).slot), LeafId{}};
    if (!is_split(next.slot)) return {LeafId(next.slot), LeafId{}};
    const std::uint32_t first = first_child(child_[next.slot]);
    return {LeafId(first + static_cast<std::uint32_t>(next_side(next.side))),
            LeafId(first + static_cast<std::uint32_t>(next.side))};
}

template <class Rule>
void TreeForest<Rule>::append_leaves(std::uint32_t slot, detail::PoolVector<std::uint32_t>& run) const {
    if (child_[slot] == k_unsplit) return run.push_back(slot);
    if (!is_split(slot)) return;
    for (std::uint32_t k = 0; k < 4; ++k) append_leaves(first_child(child_[slot]) + k, run);
}

template <class Rule>
std::vector<detail::PoolVector<std::uint32_t>> TreeForest<Rule>::leaf_runs() const {
    // Enough runs for any number of threads to be busy, few enough for their vectors not to matter.
    constexpr std::uint32_t k_most_runs = 256;
    const std::uint32_t count = std::min(root_count_, k_most_runs);
    std::vector<detail::PoolVector<std::uint32_t>> runs(count);
    for_each_index(
        count,
        [&](std::uint32_t i) {
            const auto bound = [&](std::uint64_t n) { return static_cast<std::uint32_t>(n * root_count_ / count); };
            for (std::uint32_t root = bound(i); root < bound(i + 1); ++root) append_leaves(root, runs[i]);
        },
        1);
    return runs;
}

template <class Rule>
std::vector<LeafId> TreeForest<Rule>::ordered_leaves() const {
    std::vector<LeafId> leaves;
    detail::reserve_large(leaves, leaf_count_);
    for (const auto& run : leaf_runs())
        for (const std::uint32_t slot : run) leaves.emplace_back(slot);
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

template <class Rule>
void TreeForest<Rule>::require_leaves(std::span<const LeafId> leaves) const {
    for (const LeafId leaf : leaves)
        if (!is_leaf(leaf))
            throw Error(ErrorCode::invalid_input,
                        std::string(Rule::k_name) + " " + std::to_string(leaf.value) +
                            " is not a leaf of the forest (any more): it was split or merged, or never existed");
}

// Refinement.

template <class Rule>
bool TreeForest<Rule>::mark(std::uint32_t slot) {
    const std::atomic_ref<std::uint8_t> flag(marks_[slot]);
    return flag.load(std::memory_order_relaxed) == 0 && flag.exchange(1, std::memory_order_relaxed) == 0;
}

// Marks and lists what has to be split because `slot` is: across a side without a node of its level, the parent has an
// unsplit neighbour, whose split makes one; and the other sides of creases.
template <class Rule>
void TreeForest<Rule>::close_around(std::uint32_t slot, detail::PoolVector<std::uint32_t>& found) {
    const auto need = [&](std::uint32_t needed) {
        if (mark(needed)) found.push_back(needed);
    };
    for_each_other_side(slot, need);
    for (int side = 0; side < k_sides; ++side)
        if (beyond(slot, side).slot == k_coarser) need(beyond(records_[record_of(slot)].parent, side).slot);
}

// Lists the smallest closed set of splits that holds the marked leaves, in slot order, and leaves it in marks_.
template <class Rule>
void TreeForest<Rule>::mark_closure(std::span<const LeafId> marked, detail::PoolVector<std::uint32_t>& splits) {
    detail::reserve_large(splits, marked.size() + marked.size() / 4);
    for (const LeafId leaf : marked)
        if (std::exchange(marks_[leaf.value], std::uint8_t{1}) == 0) splits.push_back(leaf.value);
    for (std::size_t begin = 0; begin < splits.size();) {
        const std::size_t end = splits.size();
        if (end - begin <= detail::k_split_grain || detail::one_thread()) {
            for (std::size_t i = begin; i < end; ++i) close_around(splits[i], splits);
        } else {
            const auto count = static_cast<std::uint32_t>(end - begin);
            std::vector<detail::PoolVector<std::uint32_t>> found((count + detail::k_split_grain - 1) /
                                                                 detail::k_split_grain);
            const auto close_block = [&](std::uint32_t block) {
                const std::size_t first = begin + std::size_t{block} * detail::k_split_grain;
                for (std::size_t i = first; i < std::min(first + detail::k_split_grain, end); ++i)
                    close_around(splits[i], found[block]);
            };
            for_each_index(static_cast<std::uint32_t>(found.size()), close_block, 1);
            for (const auto& list : found) splits.insert(splits.end(), list.begin(), list.end());
        }
        begin = end;
    }
    // The set is the same for any number of threads, the order in which it was found is not.
    constexpr std::size_t k_sparse = 64;  // slots per split from which sorting is cheaper than reading all marks
    if (splits.size() < marks_.size() / k_sparse) {
        std::sort(splits.begin(), splits.end());
        return;
    }
    splits.clear();
    std::size_t slot = 0;
    for (; slot + 8 <= marks_.size(); slot += 8) {
        std::uint64_t word;
        std::memcpy(&word, &marks_[slot], 8);
        if (word == 0) continue;
        for (std::size_t i = slot; i < slot + 8; ++i)
            if (marks_[i] != 0) splits.push_back(static_cast<std::uint32_t>(i));
    }
    for (; slot < marks_.size(); ++slot)
        if (marks_[slot] != 0) splits.push_back(static_cast<std::uint32_t>(slot));
}

template <class Rule>
typename TreeForest<Rule>::PlannedSplit TreeForest<Rule>::plan(std::uint32_t slot) const {
    PlannedSplit planned{};
    for (int side = 0; side < k_sides; ++side) {
        const Across next = beyond(slot, side);
        planned.neighbour[side] = next.slot;
        planned.side[side] = static_cast<std::uint8_t>(next.side);
        if constexpr (Rule::k_midpoints) {
            const auto bit = static_cast<std::uint8_t>(1u << side);
            if (next.slot >= k_coarser) {
                planned.owned |= bit;
                continue;
            }
            if (is_split(next.slot)) continue;
            if (marks_[next.slot] != 0) {
                if (slot < next.slot) planned.owned |= bit;
                continue;
            }
            planned.owned |= bit;
            // The first of the splits around a remaining leaf reports it.
            bool is_first = true;
            for (int i = 1; i < k_sides; ++i) {
                const Across other = beyond(next.slot, (next.side + i) % k_sides);
                if (other.slot >= k_coarser || marks_[other.slot] == 0) continue;
                is_first &= slot < other.slot || (slot == other.slot && side < other.side);
            }
            if (is_first) planned.reshaped |= bit;
        }
    }
    return planned;
}

// The record with its own new midpoints; link_record() adds what comes from the neighbours.
template <class Rule>
void TreeForest<Rule>::write_record(std::uint32_t record, std::uint32_t slot, const PlannedSplit& planned,
                                    std::uint32_t first_free_point) {
    Record& r = records_[record];
    r.parent = slot;
    r.frame = frame(slot);
    for (int side = 0; side < k_sides; ++side)
        r.link[side] = planned.neighbour[side] == k_boundary ? k_boundary : k_coarser;
    if constexpr (Rule::k_midpoints) {
        const auto own = corners(slot);
        std::uint32_t next_point = planned.first_point;
        for (int side = 0; side < k_sides; ++side) {
            r.point[side] = own[side];
            r.point[k_sides + side] = PointId::none;
            if ((planned.owned >> side & 1) == 0) continue;
            const auto reused = static_cast<std::uint32_t>(free_points_.size());
            const std::uint32_t point =
                next_point < reused ? free_points_[reused - 1 - next_point] : first_free_point + (next_point - reused);
            ++next_point;
            r.point[k_sides + side] = point;
            sites_[point] = rule_.midpoint_site(r.frame, side);
        }
    }
    child_[slot] = record;
    std::fill_n(child_.begin() + first_child(record), 4, k_unsplit);
}

template <class Rule>
void TreeForest<Rule>::link_record(std::uint32_t record, const PlannedSplit& planned) {
    Record& r = records_[record];
    for (int side = 0; side < k_sides; ++side) {
        const std::uint32_t slot = planned.neighbour[side];
        const int there = planned.side[side];
        if (slot >= k_coarser || !is_split(slot)) continue;
        Record& other = records_[child_[slot]];
        r.link[side] = 4 * child_[slot] + static_cast<std::uint32_t>(there);
        if constexpr (Rule::k_midpoints)
            if ((planned.owned >> side & 1) == 0) r.point[k_sides + side] = other.point[k_sides + there];
        // An older record, and this side of it is ours alone.
        if (marks_[slot] == 0) other.link[there] = 4 * record + static_cast<std::uint32_t>(side);
    }
}

template <class Rule>
void TreeForest<Rule>::refine(std::span<const LeafId> marked, ForestChange& change) {
    require_leaves(marked);
    for (const LeafId leaf : marked)
        if (level(leaf) >= k_max_level)
            throw Error(ErrorCode::unsupported, std::string(Rule::k_name) + " " + std::to_string(leaf.value) +
                                                    " is at level " + std::to_string(k_max_level) +
                                                    ", the deepest one");
    detail::PoolVector<std::uint32_t> splits;
    detail::RawPoolVector<PlannedSplit> planned;
    std::uint32_t new_points = 0, reshaped = 0, count = 0;
    const auto old_records = static_cast<std::uint32_t>(records_.size());
    const auto old_points = static_cast<std::uint32_t>(sites_.size());
    const auto reused_records = static_cast<std::uint32_t>(free_records_.size());
    try {
        mark_closure(marked, splits);
        count = static_cast<std::uint32_t>(splits.size());
        detail::resize_large(planned, count);
        for_each_index(
            count, [&](std::uint32_t i) { planned[i] = plan(splits[i]); }, detail::k_split_grain);
        for (PlannedSplit& p : planned) {
            p.first_point = new_points;
            p.first_reshaped = reshaped;
            new_points += static_cast<std::uint32_t>(std::popcount(p.owned));
            reshaped += static_cast<std::uint32_t>(std::popcount(p.reshaped));
        }
        const std::size_t records =
            std::max<std::size_t>(old_records, old_records - reused_records + std::size_t{count});
        const std::size_t points =
            old_points + std::max<std::size_t>(new_points, free_points_.size()) - free_points_.size();
        const std::size_t slots = root_count_ + 4 * records;
        if (slots > k_max_slots || points > k_max_slots)
            throw Error(ErrorCode::memory_limit, "the mesh would have more than 2^32 " + std::string(Rule::k_name) +
                                                     "s; use a looser tolerance");
        detail::make_room(records_, records);
        detail::make_room(child_, slots);
        detail::make_room(marks_, slots);
        detail::make_room(sites_, points);
        detail::resize_large(change.created, 4 * std::size_t{count});
        change.reshaped.resize(reshaped);
        records_.resize(records);
        child_.resize(slots, k_dead);
        marks_.resize(slots, 0);
        sites_.resize(points);
    } catch (...) {
        std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
        throw;
    }

    const auto record_for = [&](std::uint32_t i) {
        return i < reused_records ? free_records_[reused_records - 1 - i] : old_records + (i - reused_records);
    };
    for_each_index(
        count,
        [&](std::uint32_t i) {
            const std::uint32_t record = record_for(i);
            write_record(record, splits[i], planned[i], old_points);
            for (std::uint32_t k = 0; k < 4; ++k)
                change.created[4 * std::size_t{i} + k] = LeafId(first_child(record) + k);
            std::uint32_t next = planned[i].first_reshaped;
            for (int side = 0; side < k_sides; ++side)
                if ((planned[i].reshaped >> side & 1) != 0)
                    change.reshaped[next++] = LeafId(planned[i].neighbour[side]);
        },
        detail::k_split_grain);
    for_each_index(
        count, [&](std::uint32_t i) { link_record(record_for(i), planned[i]); }, detail::k_split_grain);
    for (const std::uint32_t slot : splits) marks_[slot] = 0;
    free_records_.resize(reused_records - std::min(count, reused_records));
    const auto reused_points = static_cast<std::uint32_t>(free_points_.size());
    free_points_.resize(reused_points - std::min(new_points, reused_points));
    leaf_count_ += 3 * count;
    point_count_ += new_points;
}

// Coarsening. While records are chosen, marks_ is set for the parent slots of those that go.

// Whether a split node beside a child of this one stays: it would be two levels finer than the merged node.
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

// Whether a node, all of whose children are leaves, has to stay split.
template <class Rule>
bool TreeForest<Rule>::blocks_merge(const Record& record) const {
    for (int side = 0; side < k_sides; ++side)
        if ((creases(record) >> side & 1) != 0 && marks_[records_[record.link[side] / 4].parent] == 0) return true;
    return has_finer_beside(record);
}

// Takes the marks off until none of the marked records has to stay. The reason to stay is of the form "if this stays,
// so does that", so there is one largest set that can go, whatever the order.
template <class Rule>
void TreeForest<Rule>::keep_largest_mergeable(std::span<const std::uint32_t> records) {
    std::vector<std::uint32_t> open(records.begin(), records.end());
    const auto look_again = [&](std::uint32_t link) {
        if (link < k_coarser && marks_[records_[link / 4].parent] != 0) open.push_back(link / 4);
    };
    while (!open.empty()) {
        const Record& record = records_[open.back()];
        open.pop_back();
        const std::uint32_t slot = record.parent;
        if (marks_[slot] == 0 || !blocks_merge(record)) continue;
        marks_[slot] = 0;
        for (int side = 0; side < k_sides; ++side) {
            if ((creases(record) >> side & 1) != 0) look_again(record.link[side]);
            if (!is_root(slot) && Rule::inside(number(slot), side).first == 4)
                look_again(records_[record_of(slot)].link[side]);
        }
    }
}

template <class Rule>
void TreeForest<Rule>::remove_records(std::span<const std::uint32_t> going) {
    const std::size_t points_before = free_points_.size();
    for (const std::uint32_t record : going) {
        const Record& r = records_[record];
        for (int side = 0; side < k_sides; ++side) {
            const std::uint32_t link = r.link[side];
            const bool alone = link >= k_coarser;
            const bool both_go = !alone && marks_[records_[link / 4].parent] != 0;
            if (!alone && !both_go) records_[link / 4].link[link % 4] = k_coarser;
            if constexpr (Rule::k_midpoints)
                if (alone || (both_go && record < link / 4)) {
                    sites_[r.point[k_sides + side]] = Site{};
                    free_points_.push_back(r.point[k_sides + side]);
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
    require_leaves(marked);
    std::vector<std::uint32_t> slots, going;
    slots.reserve(marked.size());
    for (const LeafId leaf : marked)
        if (!is_root(leaf.value)) slots.push_back(leaf.value - root_count_);
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
    try {
        keep_largest_mergeable(going);
    } catch (...) {
        std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
        throw;
    }
    std::erase_if(going, [&](std::uint32_t record) { return marks_[records_[record].parent] == 0; });
    change.created.clear();
    change.reshaped.clear();
    for (const std::uint32_t record : going) change.created.emplace_back(records_[record].parent);
    if constexpr (Rule::k_midpoints) {
        const auto is_going = [&](std::uint32_t slot) {
            return !is_root(slot) && marks_[records_[record_of(slot)].parent] != 0;
        };
        for (const LeafId parent : change.created)
            for (int side = 0; side < k_sides; ++side) {
                const std::uint32_t next = beyond(parent.value, side).slot;
                if (next < k_coarser && !is_split(next) && !is_going(next)) change.reshaped.emplace_back(next);
            }
        std::sort(change.reshaped.begin(), change.reshaped.end());
        change.reshaped.erase(std::unique(change.reshaped.begin(), change.reshaped.end()), change.reshaped.end());
    }
    remove_records(going);
}

}  // namespace tetrakis
