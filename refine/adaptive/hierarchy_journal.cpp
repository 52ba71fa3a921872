#include "hierarchy_journal.hpp"

#include <algorithm>
#include <tuple>

namespace tetrakis {

void HierarchyJournal::forget_before(std::uint64_t stamp) {
    oldest_ = std::max(oldest_, std::min(stamp, now_));
    while (!entries_.empty() && entries_.front().stamp <= oldest_) entries_.pop_front();
}

// A change is forgotten as a whole: half of one would tell of leaves that never were together.
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
    // A handle is added once and removed once at most, reshaped any number of times in between.
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

}  // namespace tetrakis
