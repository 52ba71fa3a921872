#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "vertex_forest.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <string>

namespace tetrakis {

// Links a new record with those of its level across its sides. Coarser records must have been linked before.
void VertexForest::link_record(std::uint32_t record) {
    Record& r = records_[record];
    for (int s = 0; s < 4; ++s) {
        const Across next = beyond(r.parent, s);
        std::uint32_t& link = r.link[static_cast<std::size_t>(s)];
        if (next.slot == k_boundary) {
            link = k_boundary;
        } else if (is_split(next.slot)) {
            const std::uint32_t other = child_[next.slot];
            link = 4 * other + static_cast<std::uint32_t>(next.side);
            records_[other].link[static_cast<std::size_t>(next.side)] = 4 * record + static_cast<std::uint32_t>(s);
        } else {
            link = k_coarser;
        }
    }
}

void VertexForest::refine(std::span<const LeafId> marked, std::vector<LeafId>& created, std::vector<LeafId>* removed) {
    require_leaves(marked);
    for (const LeafId leaf : marked)
        if (level(leaf) >= k_max_level)
            throw Error(ErrorCode::unsupported, "cell " + std::to_string(leaf.value) + " is at level " +
                                                    std::to_string(k_max_level) + " already, the deepest");
    std::vector<std::uint32_t> splits;
    try {
        const auto mark = [&](std::uint32_t slot) {
            if (marks_[slot] != 0) return;
            splits.push_back(slot);
            marks_[slot] = 1;
        };
        for (const LeafId leaf : marked) mark(leaf.value);
        // A cell's children may only lie beside cells that are as large as the cell, or smaller.
        for (std::size_t i = 0; i < splits.size(); ++i) {
            const std::uint32_t slot = splits[i];
            for_each_other_side(slot, mark);
            if (is_root(slot)) continue;
            for (const int side : {number(slot), (number(slot) + 3) % 4}) {
                const Record& above = records_[record_of(slot)];
                if (above.link[static_cast<std::size_t>(side)] == k_coarser) mark(across(above.parent, side).slot);
            }
        }
        // By level, then by slot. To read all marks is cheaper than to sort many.
        constexpr std::size_t k_sparse = 64;
        if (splits.size() < marks_.size() / k_sparse) {
            std::sort(splits.begin(), splits.end());
        } else {
            splits.clear();
            for (std::uint32_t slot = 0; slot < marks_.size(); ++slot)
                if (marks_[slot] != 0) splits.push_back(slot);
        }
        const auto is_coarser = [&](std::uint32_t a, std::uint32_t b) { return level(LeafId(a)) < level(LeafId(b)); };
        if (!std::is_sorted(splits.begin(), splits.end(), is_coarser))
            std::stable_sort(splits.begin(), splits.end(), is_coarser);
        const std::size_t fresh = splits.size() - std::min(splits.size(), free_records_.size());
        const std::uint64_t slots = child_.size() + 4 * static_cast<std::uint64_t>(fresh);
        if (slots > k_max_slots)
            throw Error(ErrorCode::memory_limit, "the mesh would have more than 2^32 vertices; refine less");
        detail::make_room(records_, records_.size() + fresh);
        detail::make_room(child_, slots);
        detail::make_room(marks_, slots);
        created.clear();
        created.reserve(4 * splits.size());
        if (removed != nullptr) {
            removed->clear();
            removed->reserve(splits.size());
        }
    } catch (...) {
        std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
        throw;
    }
    for (const std::uint32_t slot : splits) {
        std::uint32_t record = static_cast<std::uint32_t>(records_.size());
        if (!free_records_.empty()) {
            record = free_records_.back();
            free_records_.pop_back();
        } else {
            records_.emplace_back();
            child_.resize(child_.size() + 4);
            marks_.resize(marks_.size() + 4, 0);
        }
        const VertexCell cell = this->cell(LeafId(slot));
        const std::uint8_t creases = this->creases(slot);
        records_[record] = {{}, slot, cell.root, cell.at, cell.level, creases};
        child_[slot] = record;
        marks_[slot] = 0;
        for (std::uint32_t k = 0; k < 4; ++k) {
            child_[first_child(record) + k] = k_unsplit;
            created.emplace_back(first_child(record) + k);
        }
        leaf_count_ += 3;
        if (removed != nullptr) removed->emplace_back(slot);
    }
    // Coarser ones come first.
    for (const std::uint32_t slot : splits) link_record(child_[slot]);
}

// While records are chosen, marks_ is set for the slots of the cells that are to be whole again.

// Whether a split cell beside a child of this one stays: it would be two levels finer than the merged cell.
bool VertexForest::has_finer_beside(std::uint32_t record) const {
    const Record& r = records_[record];
    for (std::size_t s = 0; s < 4; ++s) {
        const std::uint32_t link = r.link[s];
        if (link >= k_coarser || (r.creases >> s & 1) != 0) continue;
        for (const std::uint32_t child : {link % 4, (link + 1) % 4}) {
            const std::uint32_t slot = first_child(link / 4) + child;
            if (is_split(slot) && marks_[slot] == 0) return true;
        }
    }
    return false;
}

// Whether a cell, all of whose children are leaves, has to stay split.
bool VertexForest::must_stay(std::uint32_t record) const {
    const Record& r = records_[record];
    for (std::size_t s = 0; s < 4; ++s)
        if ((r.creases >> s & 1) != 0 && marks_[records_[r.link[s] / 4].parent] == 0) return true;
    return has_finer_beside(record);
}

// Takes the marks off until none of the marked records has to stay. If these stay, so does that: there is one largest
// set that can go, whatever the order.
void VertexForest::keep_what_must_stay(std::span<const std::uint32_t> records) {
    std::vector<std::uint32_t> open(records.begin(), records.end());
    while (!open.empty()) {
        const std::uint32_t record = open.back();
        open.pop_back();
        const std::uint32_t slot = records_[record].parent;
        if (marks_[slot] == 0 || !must_stay(record)) continue;
        marks_[slot] = 0;
        const auto look_again = [&](std::uint32_t link) {
            if (link < k_coarser && marks_[records_[link / 4].parent] != 0) open.push_back(link / 4);
        };
        for (std::size_t s = 0; s < 4; ++s)
            if ((records_[record].creases >> s & 1) != 0) look_again(records_[record].link[s]);
        if (is_root(slot)) continue;
        for (const int side : {number(slot), (number(slot) + 3) % 4})
            look_again(records_[record_of(slot)].link[static_cast<std::size_t>(side)]);
    }
}

std::vector<LeafId> VertexForest::mergeable_siblings(LeafId leaf) const {
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
        if (has_finer_beside(record)) return {};
    }
    return siblings;
}

void VertexForest::coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created) {
    require_leaves(marked);
    std::vector<std::uint32_t> slots, going;
    for (const LeafId leaf : marked)
        if (!is_root(leaf.value)) slots.push_back(leaf.value - roots_.count());
    std::sort(slots.begin(), slots.end());
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    for (std::size_t i = 0, end = 0; i < slots.size(); i = end) {
        while (end < slots.size() && slots[end] / 4 == slots[i] / 4) ++end;
        if (end - i == 4) going.push_back(slots[i] / 4);
    }
    detail::make_room(free_records_, free_records_.size() + going.size());
    created.clear();
    created.reserve(going.size());
    for (const std::uint32_t record : going) marks_[records_[record].parent] = 1;
    try {
        keep_what_must_stay(going);
    } catch (...) {
        std::fill(marks_.begin(), marks_.end(), std::uint8_t{0});
        throw;
    }
    std::erase_if(going, [&](std::uint32_t record) { return marks_[records_[record].parent] == 0; });
    for (const std::uint32_t record : going)
        for (const std::uint32_t link : records_[record].link)
            if (link < k_coarser) records_[link / 4].link[link % 4] = k_coarser;
    for (const std::uint32_t record : going) {
        const std::uint32_t slot = records_[record].parent;
        leaf_count_ -= 3;
        child_[slot] = k_unsplit;
        marks_[slot] = 0;
        std::fill_n(child_.begin() + first_child(record), 4, k_dead);
        free_records_.push_back(record);
        created.emplace_back(slot);
    }
}

}  // namespace tetrakis
