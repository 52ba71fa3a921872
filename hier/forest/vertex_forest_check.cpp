#include "vertex_forest.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis {

namespace {

std::string about(std::uint32_t slot, const std::string& what) { return "cell " + std::to_string(slot) + ": " + what; }

}  // namespace

std::optional<std::string> VertexForest::check_record(std::uint32_t record) const {
    const Record& r = records_[record];
    const std::uint32_t slot = r.parent;
    if (slot >= child_.size() || child_[slot] != record)
        return "record " + std::to_string(record) + " is not that of its cell " + std::to_string(slot);
    const VertexCell place = cell(LeafId(slot));
    if (r.root != place.root || r.at != place.at || r.level != place.level)
        return about(slot, "its record has another place");
    if (r.creases != creases(slot)) return about(slot, "its record lies along other creases");
    if (r.level >= k_max_level) return about(slot, "is split below the deepest level");
    for (int s = 0; s < 4; ++s) {
        const Across next = beyond(slot, s);
        const std::string side = "side " + std::to_string(s);
        if (next.slot == k_coarser) return about(slot, side + " has a neighbour two levels coarser than its children");
        const std::uint32_t expected = next.slot == k_boundary ? k_boundary
                                       : is_split(next.slot)
                                           ? 4 * child_[next.slot] + static_cast<std::uint32_t>(next.side)
                                           : k_coarser;
        if (r.link[static_cast<std::size_t>(s)] != expected) return about(slot, side + " has a wrong link");
        if (is_crease(slot, s) && expected >= k_coarser)
            return about(slot, side + " is split on one side of its crease only");
        if (expected >= k_coarser) continue;
        if (records_[expected / 4].link[expected % 4] != 4 * record + static_cast<std::uint32_t>(s))
            return about(slot, side + " has a one-way link");
    }
    return std::nullopt;
}

std::optional<std::string> VertexForest::check() const {
    const std::uint32_t roots = roots_.count();
    if (roots_.link.size() != 4 * std::size_t{roots} || roots_.crease.size() != roots || roots_.hole.size() != roots)
        return "the arrays of roots have wrong sizes";
    for (std::uint32_t i = 0; i < roots_.link.size(); ++i) {
        const std::uint32_t link = roots_.link[i];
        if (link != k_boundary && (link >= roots_.link.size() || roots_.link[link] != i))
            return about(i / 4, "side " + std::to_string(i % 4) + " of the root has a one-way link");
        const bool crease = is_crease(i / 4, static_cast<int>(i % 4));
        if (crease && (link == k_boundary || !is_crease(link / 4, static_cast<int>(link % 4))))
            return about(i / 4, "side " + std::to_string(i % 4) + " of the root has a crease without another side");
    }
    if (child_.size() != roots + 4 * records_.size() || marks_.size() != child_.size())
        return "the arrays of slots have wrong sizes";
    std::size_t leaves = 0, records = 0;
    std::vector<std::uint32_t> open;
    for (std::uint32_t r = 0; r < roots; ++r) open.push_back(r);
    while (!open.empty()) {
        const std::uint32_t slot = open.back();
        open.pop_back();
        if (marks_[slot] != 0) return about(slot, "is marked");
        if (!is_split(slot)) {
            if (child_[slot] == k_dead) return about(slot, "is dead, but its parent is split");
            ++leaves;
            continue;
        }
        if (child_[slot] >= records_.size()) return about(slot, "has no record");
        if (records_[child_[slot]].parent != slot) return about(slot, "has the record of another cell");
        if (auto fault = check_record(child_[slot])) return fault;
        ++records;
        for (std::uint32_t k = 0; k < 4; ++k) open.push_back(first_child(child_[slot]) + k);
    }
    if (leaves != leaf_count_) return "the number of leaves is wrong";
    if (records + free_records_.size() != records_.size()) return "a record is lost";
    for (const std::uint32_t record : free_records_)
        for (std::uint32_t k = 0; k < 4; ++k)
            if (child_[first_child(record) + k] != k_dead)
                return "record " + std::to_string(record) + " is free and in use";
    return std::nullopt;
}

}  // namespace tetrakis
