#include "../../hier/base/error.hpp"
#include "../families/hierarchy_family.hpp"
#include "hierarchy.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <span>
#include <string>
#include <tuple>

namespace tetrakis {

void HierarchyJournal::forget_before(std::uint64_t stamp) {
    oldest_ = std::max(oldest_, std::min(stamp, now_));
    while (!entries_.empty() && entries_.front().stamp <= oldest_) entries_.pop_front();
}

// A change is forgotten as a whole: parts of one would mix leaves that never existed together.
void HierarchyJournal::trim() {
    while (entries_.size() > limit_) forget_before(entries_.front().stamp);
}

HierarchyChanges HierarchyJournal::since(std::uint64_t stamp) const {
    HierarchyChanges changes;
    if (stamp < oldest_) {
        changes.complete = false;
        return changes;
    }
    const auto first =
        std::partition_point(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.stamp <= stamp; });
    std::vector<Entry> entries(first, entries_.end());
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return std::tie(a.leaf.leaf, a.kind, a.stamp) < std::tie(b.leaf.leaf, b.kind, b.stamp);
    });
    // A handle is added at most once and removed at most once; in between it may be reshaped any number of times.
    for (std::size_t i = 0; i < entries.size();) {
        bool added = false, removed = false;
        std::size_t j = i;
        for (; j < entries.size() && entries[j].leaf.leaf == entries[i].leaf.leaf; ++j) {
            added |= entries[j].kind == Kind::added;
            removed |= entries[j].kind == Kind::removed;
        }
        if (added && !removed) changes.added.push_back(entries[i].leaf);
        if (!added && removed) changes.removed.push_back(entries[i].leaf);
        if (!added && !removed) changes.reshaped.push_back(entries[i].leaf);
        i = j;
    }
    for (auto* list : {&changes.added, &changes.removed, &changes.reshaped})
        std::sort(list->begin(), list->end(), [](const JournalLeaf& a, const JournalLeaf& b) {
            return std::tie(a.node, a.leaf) < std::tie(b.node, b.leaf);
        });
    return changes;
}

std::uint64_t Hierarchy::stamp() { return journal_.start(); }

void Hierarchy::forget_before(std::uint64_t stamp) { journal_.forget_before(stamp); }

void Hierarchy::limit_journal(std::size_t entries) { journal_.limit(entries); }

namespace {

bool has_corner(const LeafView& view, PointId point) {
    const auto corners = std::span(view.point).first(view.corner_count);
    return std::ranges::find(corners, point) != corners.end();
}

}  // namespace

// Moves from neighbour to neighbour, so it finds one fan of leaves only.
std::vector<LeafId> Hierarchy::leaves_around(LeafId start, PointId corner) const {
    std::vector<LeafId> leaves{start};
    std::set<LeafId> found{start};
    for (std::size_t i = 0; i < leaves.size(); ++i)
        for (int side = 0, sides = family_->view(leaves[i]).corner_count; side < sides; ++side)
            for (const LeafId across : family_->neighbours(leaves[i], side))
                if (across.valid() && has_corner(family_->view(across), corner) && found.insert(across).second)
                    leaves.push_back(across);
    return leaves;
}

HierarchyChanges Hierarchy::changes_since(std::uint64_t stamp) const {
    require_not_lost();
    if (!journal_.active() || stamp > journal_.now())
        throw Error(ErrorCode::invalid_input,
                    "stamp " + std::to_string(stamp) + " was never given by this hierarchy; ask stamp() for one first");
    HierarchyChanges changes = journal_.since(stamp);
    if (!changes.complete) return changes;
    // Earlier levels of the vertices, from removed leaves and from leaves around them that were not changed.
    struct Levels {
        int before = -1, after = -1;
    };
    std::map<Site, Levels> levels;
    for (const JournalLeaf& leaf : changes.removed) {
        const NodeView view = family_->view(leaf.node);
        for (std::size_t k = 0; k < view.corner_count; ++k) {
            int& before = levels[view.corner[k]].before;
            before = std::max<int>(before, view.level);
        }
    }
    std::vector<LeafHandle> added;
    for (const JournalLeaf& leaf : changes.added) added.push_back(leaf.leaf);
    std::sort(added.begin(), added.end());
    const auto add_level = [&](Levels& l, LeafId leaf, int level) {
        l.after = std::max(l.after, level);
        if (!std::binary_search(added.begin(), added.end(), handle(leaf))) l.before = std::max(l.before, level);
    };
    const auto look_around = [&](const LeafView& view, std::size_t k) {
        Levels& l = levels[view.corner[k]];
        if (l.after >= 0) return;
        for (const LeafId leaf : leaves_around(view.leaf.slot, view.point[k]))
            add_level(l, leaf, family_->view(leaf).level);
    };
    if (has_holes_) {
        // Holes may divide the leaves around a vertex into several fans; leaves_around() finds only one.
        for (const JournalLeaf& leaf : changes.added) {
            const LeafView view = family_->view(leaf.leaf.slot);
            for (std::size_t k = 0; k < view.corner_count; ++k) (void)levels[view.corner[k]];
        }
        for (std::uint32_t slot = 0; slot < family_->leaf_slots(); ++slot) {
            if (!family_->is_leaf(LeafId(slot))) continue;
            const LeafView view = family_->view(LeafId(slot));
            for (std::size_t k = 0; k < view.corner_count; ++k)
                if (const auto found = levels.find(view.corner[k]); found != levels.end())
                    add_level(found->second, view.leaf.slot, view.level);
        }
    }
    for (const JournalLeaf& leaf : has_holes_ ? std::vector<JournalLeaf>{} : changes.added) {
        const LeafView view = family_->view(leaf.leaf.slot);
        for (std::size_t k = 0; k < view.corner_count; ++k) look_around(view, k);
        // A vertex that hangs on a merged leaf may have been a corner of its parts: the finer leaves share it.
        for (int side = 0; side < view.corner_count; ++side) {
            const auto [first, second] = family_->neighbours(view.leaf.slot, side);
            if (!second.valid()) continue;
            const LeafView a = family_->view(first), b = family_->view(second);
            for (std::size_t k = 0; k < a.corner_count; ++k)
                if (has_corner(b, a.point[k])) look_around(a, k);
        }
    }
    for (const auto& [site, l] : levels)
        if (l.before >= 0 && l.after >= 0 && l.before != l.after) changes.moved.push_back(site);
    return changes;
}

}  // namespace tetrakis
