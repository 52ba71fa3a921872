#pragma once

#include "../../hier/forest/site.hpp"
#include "../families/hierarchy_leaf.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace tetrakis {

/// A leaf of now or of earlier, with its node.
struct JournalLeaf {
    LeafHandle leaf;
    HierarchyNode node;
};

/// Changes of a hierarchy's leaves and vertices since a stamp.
struct HierarchyChanges {
    /// False if the journal does not reach back that far: the lists are empty, and all must be read anew.
    bool complete = true;
    std::vector<JournalLeaf> added;     ///< leaves now that were no leaves then
    std::vector<JournalLeaf> removed;   ///< leaves then that are no leaves now; their handles are those of then
    std::vector<JournalLeaf> reshaped;  ///< leaves then and now whose output faces may have changed
    /// Vertices then and now whose finest leaf has another level now, so they have moved under MeshPositions::finest.
    /// Limit positions, and positions on one level, never move.
    std::vector<Site> moved;
};

/// The log of changes for Hierarchy::changes_since(). It is off until the first stamp is asked for.
class HierarchyJournal {
  public:
    enum class Kind : std::uint8_t { added, removed, reshaped };
    struct Entry {
        JournalLeaf leaf;
        std::uint64_t stamp;  // number of its change
        Kind kind;
    };

    bool active() const { return active_; }
    std::uint64_t start() {
        active_ = true;
        return now_;
    }
    std::uint64_t now() const { return now_; }

    /// Begins a change; the caller then adds its entries.
    void begin_change() { ++now_; }
    void add(Kind kind, const JournalLeaf& leaf) { entries_.push_back({leaf, now_, kind}); }
    void end_change() { trim(); }

    void forget_before(std::uint64_t stamp);
    void limit(std::size_t entries) {
        limit_ = entries;
        trim();
    }
    /// Forgets everything: no earlier stamp is answered any more.
    void restart() {
        entries_.clear();
        oldest_ = ++now_;
    }
    /// The net effect on each handle of the changes after a stamp.
    HierarchyChanges since(std::uint64_t stamp) const;
    std::uint64_t memory_bytes() const { return entries_.size() * sizeof(Entry); }

  private:
    void trim();

    bool active_ = false;
    std::uint64_t now_ = 0, oldest_ = 0;
    std::size_t limit_ = std::size_t{1} << 24;
    std::deque<Entry> entries_;
};

}  // namespace tetrakis
