#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "../base/parallel.hpp"
#include "triangle_forest.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

// Some ten microseconds of closure or record writing: more than it costs to hand a block to a thread.
constexpr std::uint32_t k_split_grain = 256;

}  // namespace

// What refine() finds out about one split before it writes anything.
struct TriangleForest::PlannedSplit {
    std::array<std::uint32_t, 3> neighbour;  // slots, or k_coarser, k_boundary
    std::array<std::uint8_t, 3> edge;        // those edges seen from there
    std::uint8_t owned : 3, changed : 3;     // edges whose midpoint is new and ours; whose neighbour we report
    std::uint32_t first_point, first_changed;
};

bool TriangleForest::mark(std::uint32_t slot) {
    const std::atomic_ref<std::uint8_t> flag(marks_[slot]);
    return flag.load(std::memory_order_relaxed) == 0 && flag.exchange(1, std::memory_order_relaxed) == 0;
}

// Marks and lists what has to be split because `slot` is: across an edge without a triangle of its level, the parent
// has an unsplit neighbour, whose split makes one.
void TriangleForest::close_around(std::uint32_t slot, detail::PoolVector<std::uint32_t>& found) {
    for (std::uint32_t e = 0; e < 3; ++e) {
        if (neighbour(slot, e).slot != k_coarser) continue;
        const std::uint32_t parent = records_[(slot - root_count_) / 4].parent;
        const std::uint32_t coarse = neighbour(parent, e).slot;
        if (mark(coarse)) found.push_back(coarse);
    }
}

// Lists the smallest closed set of splits that holds the marked leaves, in slot order, and leaves it in marks_.
void TriangleForest::mark_closure(std::span<const LeafId> marked, detail::PoolVector<std::uint32_t>& splits) {
    detail::reserve_large(splits, marked.size() + marked.size() / 4);
    for (const LeafId leaf : marked)
        if (std::exchange(marks_[leaf.value], 1) == 0) splits.push_back(leaf.value);
    for (std::size_t begin = 0; begin < splits.size();) {
        const std::size_t end = splits.size();
        if (end - begin <= k_split_grain || detail::one_thread()) {
            for (std::size_t i = begin; i < end; ++i) close_around(splits[i], splits);
        } else {
            const auto count = static_cast<std::uint32_t>(end - begin);
            std::vector<detail::PoolVector<std::uint32_t>> found((count + k_split_grain - 1) / k_split_grain);
            const auto close_block = [&](std::uint32_t block) {
                const std::size_t first = begin + std::size_t{block} * k_split_grain;
                for (std::size_t i = first; i < std::min(first + k_split_grain, end); ++i)
                    close_around(splits[i], found[block]);
            };
            for_each_index(static_cast<std::uint32_t>(found.size()), close_block, 1);
            for (const auto& list : found) splits.insert(splits.end(), list.begin(), list.end());
        }
        begin = end;
    }
    // The set is the same for any number of threads, the order in which it was found is not.
    constexpr std::size_t sparse = 64;  // slots per split from which sorting is cheaper than reading all marks
    if (splits.size() < marks_.size() / sparse) {
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
            if (marks_[i]) splits.push_back(static_cast<std::uint32_t>(i));
    }
    for (; slot < marks_.size(); ++slot)
        if (marks_[slot]) splits.push_back(static_cast<std::uint32_t>(slot));
}

TriangleForest::PlannedSplit TriangleForest::plan(std::uint32_t slot) const {
    PlannedSplit planned{};
    for (std::uint32_t e = 0; e < 3; ++e) {
        const Neighbour next = neighbour(slot, e);
        planned.neighbour[e] = next.slot;
        planned.edge[e] = static_cast<std::uint8_t>(next.edge);
        const auto bit = static_cast<std::uint8_t>(1u << e);
        if (next.slot >= k_boundary) {
            planned.owned |= bit;
            continue;
        }
        if (is_split(next.slot)) continue;
        if (marks_[next.slot]) {
            if (slot < next.slot) planned.owned |= bit;
            continue;
        }
        planned.owned |= bit;
        // The first of the splits around a remaining leaf reports it.
        bool is_first = true;
        for (std::uint32_t i = 1; i < 3; ++i) {
            const Neighbour other = neighbour(next.slot, (next.edge + i) % 3);
            if (other.slot >= k_boundary || !marks_[other.slot]) continue;
            is_first &= slot < other.slot || (slot == other.slot && e < other.edge);
        }
        if (is_first) planned.changed |= bit;
    }
    return planned;
}

Site TriangleForest::midpoint_site(const Frame& frame, std::uint32_t edge) const {
    const std::uint32_t step = frame.is_reversed ? ~std::uint32_t{0} : 1;
    LatticePoint at{2 * frame.at.x, 2 * frame.at.y};
    if (edge != 2) at.x += step;
    if (edge != 0) at.y += step;
    const Site site{HalfedgeId(3 * frame.face), at, static_cast<std::uint8_t>(frame.level + 1)};
    const bool is_on_side = edge == 0   ? at.y == 0
                            : edge == 2 ? at.x == 0
                                        : at.x + at.y == std::uint32_t{1} << site.level;
    return is_on_side ? canonical_.canonical(site) : site;
}

// The record with its own new midpoints; link_record() adds what comes from the neighbours.
void TriangleForest::write_record(std::uint32_t record, std::uint32_t slot, const PlannedSplit& planned,
                                  std::uint32_t first_free_point) {
    const Frame f = frame(slot);
    const auto c = corners(slot);
    Record& r = records_[record];
    r.parent = slot;
    r.face = f.face;
    r.at = f.at;
    r.level = f.level;
    r.is_reversed = f.is_reversed;
    std::uint32_t next_point = planned.first_point;
    for (std::uint32_t e = 0; e < 3; ++e) {
        r.point[e] = c[e];
        r.link[e] = planned.neighbour[e] == k_boundary ? k_boundary : k_coarser;
        r.point[3 + e] = PointId::none;
        if (!(planned.owned >> e & 1)) continue;
        const auto reused = static_cast<std::uint32_t>(free_points_.size());
        const std::uint32_t point =
            next_point < reused ? free_points_[reused - 1 - next_point] : first_free_point + (next_point - reused);
        ++next_point;
        r.point[3 + e] = point;
        sites_[point] = midpoint_site(f, e);
    }
    child_[slot] = record;
    std::fill_n(child_.begin() + first_child(record), 4, k_unsplit);
}

void TriangleForest::link_record(std::uint32_t record, const PlannedSplit& planned) {
    Record& r = records_[record];
    for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t slot = planned.neighbour[e], edge = planned.edge[e];
        if (slot >= k_boundary || !is_split(slot)) continue;
        Record& other = records_[child_[slot]];
        r.link[e] = 4 * child_[slot] + edge;
        if (!(planned.owned >> e & 1)) r.point[3 + e] = other.point[3 + edge];
        if (!marks_[slot]) other.link[edge] = 4 * record + e;  // an older record, and this edge of it is ours alone
    }
}

void TriangleForest::refine(std::span<const LeafId> marked, std::vector<LeafId>& created,
                            std::vector<LeafId>& changed) {
    require_leaves(marked);
    for (const LeafId leaf : marked)
        if (level(leaf) >= k_max_level)
            throw Error(ErrorCode::unsupported, "leaf " + std::to_string(leaf.value) + " of face " +
                                                    std::to_string(face(leaf).value) + " is at level " +
                                                    std::to_string(k_max_level) + ", the deepest one");
    detail::PoolVector<std::uint32_t> splits;
    detail::RawPoolVector<PlannedSplit> planned;
    std::uint32_t new_points = 0, new_changed = 0, count = 0;
    const auto old_records = static_cast<std::uint32_t>(records_.size());
    const auto old_points = static_cast<std::uint32_t>(sites_.size());
    const auto reused_records = static_cast<std::uint32_t>(free_records_.size());
    try {
        mark_closure(marked, splits);
        count = static_cast<std::uint32_t>(splits.size());
        detail::resize_large(planned, count);
        for_each_index(
            count, [&](std::uint32_t i) { planned[i] = plan(splits[i]); }, k_split_grain);
        for (PlannedSplit& p : planned) {
            p.first_point = new_points;
            p.first_changed = new_changed;
            new_points += static_cast<std::uint32_t>(std::popcount(static_cast<unsigned>(p.owned)));
            new_changed += static_cast<std::uint32_t>(std::popcount(static_cast<unsigned>(p.changed)));
        }
        const std::size_t records =
            std::max<std::size_t>(old_records, old_records - reused_records + std::size_t{count});
        const std::size_t points =
            old_points + std::max<std::size_t>(new_points, free_points_.size()) - free_points_.size();
        if (root_count_ + 4 * records > k_max_slots || points > k_max_slots)
            throw Error(ErrorCode::memory_limit,
                        "the mesh would have more than 2^32 triangles; use a looser tolerance");
        detail::make_room(records_, records);
        detail::make_room(child_, root_count_ + 4 * records);
        detail::make_room(marks_, root_count_ + 4 * records);
        detail::make_room(sites_, points);
        detail::resize_large(created, 4 * std::size_t{count});
        changed.resize(new_changed);
        records_.resize(records);
        child_.resize(root_count_ + 4 * records, k_dead);
        marks_.resize(root_count_ + 4 * records, 0);
        sites_.resize(points);
    } catch (...) {
        std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
        throw;
    }

    const auto record_of = [&](std::uint32_t i) {
        return i < reused_records ? free_records_[reused_records - 1 - i] : old_records + (i - reused_records);
    };
    for_each_index(
        count,
        [&](std::uint32_t i) {
            const std::uint32_t record = record_of(i);
            write_record(record, splits[i], planned[i], old_points);
            for (std::uint32_t k = 0; k < 4; ++k) created[4 * std::size_t{i} + k] = LeafId(first_child(record) + k);
            std::uint32_t next = planned[i].first_changed;
            for (std::uint32_t e = 0; e < 3; ++e)
                if (planned[i].changed >> e & 1) changed[next++] = LeafId(planned[i].neighbour[e]);
        },
        k_split_grain);
    for_each_index(
        count, [&](std::uint32_t i) { link_record(record_of(i), planned[i]); }, k_split_grain);
    for (const std::uint32_t slot : splits) marks_[slot] = 0;
    free_records_.resize(reused_records - std::min(count, reused_records));
    const auto reused_points = static_cast<std::uint32_t>(free_points_.size());
    free_points_.resize(reused_points - std::min(new_points, reused_points));
    leaf_count_ += 3 * count;
    point_count_ += new_points;
}

std::uint32_t TriangleForest::split(LeafId leaf) {
    std::vector<LeafId> created, changed;
    refine({&leaf, 1}, created, changed);
    return static_cast<std::uint32_t>(created.size() / 4);
}

}  // namespace tetrakis
