#include "../base/error.hpp"
#include "triangle_forest.hpp"

#include <algorithm>
#include <string>

namespace tetrakis {

// While records are chosen, marks_ is set for the parent slots of those that go.

// Whether the record's triangle has to stay split, given that all its children are leaves: a finer neighbour of a child
// that stays would be two levels finer than the merged triangle.
bool TriangleForest::must_stay(std::uint32_t record) const {
    for (const std::uint32_t link : records_[record].link) {
        if (link >= k_boundary) continue;
        const std::uint32_t edge = link % 4;
        for (const std::uint32_t child : {edge, (edge + 1) % 3}) {
            const std::uint32_t slot = first_child(link / 4) + child;
            if (is_split(slot) && !marks_[slot]) return true;
        }
    }
    return false;
}

// Takes the marks off until none of the marked records has to stay. The reason to stay is of the form "if this stays,
// so does that", so there is one largest set that can go, whatever the order.
void TriangleForest::keep_what_must_stay(std::span<const std::uint32_t> records) {
    std::vector<std::uint32_t> open(records.begin(), records.end());
    const auto look_at = [&](std::uint32_t link) {
        if (link < k_boundary && marks_[records_[link / 4].parent]) open.push_back(link / 4);
    };
    while (!open.empty()) {
        const std::uint32_t record = open.back();
        open.pop_back();
        const std::uint32_t parent = records_[record].parent;
        if (!marks_[parent] || !must_stay(record)) continue;
        marks_[parent] = 0;
        if (parent < root_count_ || (parent - root_count_) % 4 == 3) continue;
        const std::uint32_t corner = (parent - root_count_) % 4;
        const Record& above = records_[(parent - root_count_) / 4];
        look_at(above.link[corner]);
        look_at(above.link[(corner + 2) % 3]);
    }
}

void TriangleForest::remove_records(std::span<const std::uint32_t> going) {
    const auto free_point = [&](std::uint32_t point) {
        sites_[point] = Site{};
        free_points_.push_back(point);
    };
    const std::size_t points_before = free_points_.size();
    for (const std::uint32_t record : going) {
        const Record& r = records_[record];
        for (std::uint32_t e = 0; e < 3; ++e) {
            const std::uint32_t link = r.link[e];
            if (link >= k_boundary) {
                free_point(r.point[3 + e]);
            } else if (marks_[records_[link / 4].parent]) {
                if (record < link / 4) free_point(r.point[3 + e]);
            } else {
                records_[link / 4].link[link % 4] = k_coarser;
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

// The record whose children are the leaf and its three siblings, if they can be merged; else k_coarser.
std::uint32_t TriangleForest::mergeable_record(LeafId leaf) const {
    if (!is_leaf(leaf) || leaf.value < root_count_) return k_coarser;
    const std::uint32_t record = (leaf.value - root_count_) / 4;
    for (std::uint32_t k = 0; k < 4; ++k)
        if (is_split(first_child(record) + k)) return k_coarser;
    return must_stay(record) ? k_coarser : record;
}

bool TriangleForest::can_merge(LeafId leaf) const { return mergeable_record(leaf) != k_coarser; }

LeafId TriangleForest::merge(LeafId leaf) {
    require_leaves({&leaf, 1});
    const std::uint32_t record = mergeable_record(leaf);
    if (record == k_coarser)
        throw Error(ErrorCode::invalid_input,
                    "leaf " + std::to_string(leaf.value) +
                        " cannot be merged: it is a root, or a sibling or a neighbour of one is split further");
    detail::make_room(free_points_, free_points_.size() + 3);
    detail::make_room(free_records_, free_records_.size() + 1);
    const LeafId parent(records_[record].parent);
    remove_records({&record, 1});
    return parent;
}

void TriangleForest::coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created,
                             std::vector<LeafId>& changed) {
    require_leaves(marked);
    std::vector<std::uint32_t> slots, going;
    slots.reserve(marked.size());
    for (const LeafId leaf : marked)
        if (leaf.value >= root_count_) slots.push_back(leaf.value - root_count_);
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    for (std::size_t i = 0; i + 3 < slots.size(); ++i)
        if (slots[i] % 4 == 0 && slots[i + 3] == slots[i] + 3) going.push_back(slots[i] / 4);
    detail::make_room(free_points_, free_points_.size() + 3 * going.size());
    detail::make_room(free_records_, free_records_.size() + going.size());
    created.reserve(going.size());
    changed.reserve(3 * going.size());

    for (const std::uint32_t record : going) marks_[records_[record].parent] = 1;
    try {
        keep_what_must_stay(going);
    } catch (...) {
        std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
        throw;
    }
    std::erase_if(going, [&](std::uint32_t record) { return !marks_[records_[record].parent]; });
    created.clear();
    changed.clear();
    for (const std::uint32_t record : going) created.push_back(LeafId(records_[record].parent));
    const auto is_going = [&](std::uint32_t slot) {
        return slot >= root_count_ && marks_[records_[(slot - root_count_) / 4].parent];
    };
    for (const LeafId parent : created)
        for (std::uint32_t e = 0; e < 3; ++e) {
            const std::uint32_t next = neighbour(parent.value, e).slot;
            if (next < k_boundary && !is_split(next) && !is_going(next)) changed.push_back(LeafId(next));
        }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    remove_records(going);
}

}  // namespace tetrakis
