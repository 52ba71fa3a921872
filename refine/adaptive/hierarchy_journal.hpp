#pragma once

#include "../../hier/forest/site.hpp"
#include "../families/hierarchy_leaf.hpp"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace tetrakis {

/// A leaf that is, or was, with its node.
struct JournalLeaf {
    LeafHandle leaf;
    HierarchyNode node;
};

/// What became of a hierarchy's leaves and vertices since a stamp.
struct HierarchyChanges {
    /// False where the journal does not reach back so far: the lists are empty, and all has to be read anew.
    bool complete = true;
    std::vector<JournalLeaf> added;     ///< leaves now that were none then
    std::vector<JournalLeaf> removed;   ///< leaves then that are none now, by their handles of then
    std::vector<JournalLeaf> reshaped;  ///< leaves then and now whose output faces may be others
    /// Vertices then and now whose finest leaf has another level now, so that they are elsewhere under
    /// MeshPositions::finest. Limit positions and those of a level never move.
    std::vector<Site> moved;
};

/// The log behind Hierarchy::changes_since(). Off until its first stamp is asked for.
class HierarchyJournal {
  public:
    enum class Kind : std::uint8_t { added, removed, reshaped };
    struct Entry {
        JournalLeaf leaf;
        std::uint64_t stamp;  // the change it belongs to
        Kind kind;
    };

    bool active() const { return active_; }
    std::uint64_t start() {
        active_ = true;
        return now_;
    }
    std::uint64_t now() const { return now_; }

    /// A change begins; its entries follow.
    void begin_change() { ++now_; }
    void add(Kind kind, const JournalLeaf& leaf) { entries_.push_back({leaf, now_, kind}); }
    void end_change() { trim(); }

    void forget_before(std::uint64_t stamp);
    void limit(std::size_t entries) {
        limit_ = entries;
        trim();
    }
    /// All is different now: no earlier stamp is answered.
    void restart() {
        entries_.clear();
        oldest_ = ++now_;
    }
    /// Entries of the changes after a stamp, in their order: the net effect on each handle.
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
