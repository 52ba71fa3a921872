#pragma once

#include "../base/ids.hpp"
#include "../base/memory.hpp"
#include "../forest/exported_triangles.hpp"
#include "../forest/site.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// Position of a node in the trees, with data of its rule.
struct TreeFrame {
    std::uint32_t root = 0;
    LatticePoint at;  ///< corner 0, at the node's level
    std::uint8_t level = 0;
    std::uint8_t flags = 0;  ///< meaning depends on the rule
};

/// Restricted quadtrees: a node of 3 or 4 sides is split into four children, and leaves that share a side (or part of
/// it) differ by at most one level. A rule defines the nodes. It has
///   k_sides, k_name, k_midpoints     number of sides; what messages call a node; whether split sides have points
///   k_creases                        whether sides may lie on creases: both sides are split and merged together
///   inside(child, side)              the sibling across a child's side, and its side; child 4 on the parent's sides.
///                                    A parent's side s has the children s and s + 1 beside it
///   child_frame(parent, child)       position of a child
///   root_count(), has_root(root), root_frame(root), root_link(root, side)
///   root_corners, child_corners, midpoint_site      with k_midpoints: the points there
///   memory_bytes()
///
/// Storage: a record per split node (there are a third as many as leaves), and 5 bytes per node. Root r has slot r; the
/// children of record k have slots R + 4 k to R + 4 k + 3. Slots are used again after a merge.
template <class Rule>
class TreeForest {
  public:
    static constexpr int k_sides = Rule::k_sides;

    /// Leaves are numbered below this; some of these numbers are not leaves.
    std::uint32_t leaf_slots() const { return static_cast<std::uint32_t>(child_.size()); }
    bool is_leaf(LeafId leaf) const { return leaf.value < child_.size() && child_[leaf.value] == k_unsplit; }
    std::uint32_t leaf_count() const { return leaf_count_; }
    int level(LeafId leaf) const { return is_root(leaf.value) ? 0 : records_[record_of(leaf.value)].frame.level + 1; }
    /// The children taken from the root, two bits each, the first in the most significant of 2 level(leaf) bits.
    /// O(level).
    std::uint64_t path(LeafId leaf) const;
    std::uint32_t root(LeafId leaf) const { return root_of(leaf.value); }
    /// Position of a node, leaf or not. @param path  as path()
    TreeFrame frame(std::uint32_t root, std::uint64_t path, int level) const {
        TreeFrame at = rule_.root_frame(root);
        while (level-- > 0) at = Rule::child_frame(at, static_cast<int>(path >> 2 * level & 3));
        return at;
    }
    /// The split node whose child this leaf is; invalid for a root. A split node's slot is not a leaf.
    LeafId parent(LeafId leaf) const {
        return is_root(leaf.value) ? LeafId{} : LeafId(records_[record_of(leaf.value)].parent);
    }
    /// The leaves across a side: none (both invalid) if the surface ends or a crease lies there, two (in the order
    /// along the side) if they are finer, else one.
    std::array<LeafId, 2> neighbours(LeafId leaf, int side) const;
    /// All leaves by root, then by path, child 0 first. O(leaves).
    std::vector<LeafId> ordered_leaves() const;

    /// Splits the marked leaves and all leaves that the rule of levels requires, each once: the smallest such
    /// refinement. At creases, leaves on the other sides are split as well.
    /// @param marked   leaves in any order; repetitions are allowed
    /// @throws Error   unsupported: a marked leaf is at level k_max_level; memory_limit: more than 2^32 nodes. The
    ///                 forest is then unchanged.
    /// Cost: O(nodes split), one thread. The result (slots and points included) depends only on the set of marked
    /// leaves and the calls before.
    void refine(std::span<const LeafId> marked, ForestChange& change);

    /// The leaf and its three siblings, and the children of their parent's vertex on other sides of creases; empty
    /// unless all are leaves and may be merged by the rule of levels.
    std::vector<LeafId> mergeable_siblings(LeafId leaf) const;
    /// Merges as many fully marked groups of siblings as the rule of levels allows, all at once (one merge may need
    /// another): the exact inverse of refine(). Points that are not used any more are removed.
    void coarsen(std::span<const LeafId> marked, ForestChange& change);

    /// Bytes allocated.
    std::uint64_t memory_bytes() const;
    /// Frees the memory reserved for the next change, except free slots and points: slots and points keep their
    /// numbers. O(leaves).
    void shrink();
    /// Whether there are free slots or points.
    bool has_free_slots() const { return !free_records_.empty() || !free_points_.empty(); }

  protected:
    // Values of child_ that are no record numbers.
    static constexpr std::uint32_t k_unsplit = 0xFFFF'FFFFu;  // a leaf
    static constexpr std::uint32_t k_dead = 0xFFFF'FFFEu;     // a hole, or a child of a record that is not in use
    // Values of slots and links that are no numbers.
    static constexpr std::uint32_t k_coarser = 0xFFFF'FFFEu;   // no node, or record, of this level exists there
    static constexpr std::uint32_t k_boundary = 0xFFFF'FFFFu;  // the surface ends
    // Largest number of slots: record numbers share their 32 bits with a side in links.
    static constexpr std::uint64_t k_max_slots = 0xFFFF'FFF0u;

    /// A split node.
    struct Record {
        std::array<std::uint32_t, k_sides> link;  // across side s: 4 * record + its side; k_coarser, k_boundary
        std::uint32_t parent;                     // the node's slot
        TreeFrame frame;                          // of the node, not of its children
        [[no_unique_address]] typename Rule::Points point;  // its corners, then the midpoints of its sides
    };
    struct Across {
        std::uint32_t slot;  // the node of the same level across a side; or k_coarser, k_boundary
        int side;            // number of that side in that node
    };

    explicit TreeForest(Rule rule);

    static constexpr int next_side(int side) { return side + 1 == k_sides ? 0 : side + 1; }
    bool is_split(std::uint32_t slot) const { return child_[slot] < k_dead; }
    bool is_root(std::uint32_t slot) const { return slot < root_count_; }
    std::uint32_t first_child(std::uint32_t record) const { return root_count_ + 4 * record; }
    std::uint32_t record_of(std::uint32_t slot) const { return (slot - root_count_) / 4; }
    int number(std::uint32_t slot) const { return static_cast<int>((slot - root_count_) % 4); }
    std::uint32_t root_of(std::uint32_t slot) const {
        return is_root(slot) ? slot : records_[record_of(slot)].frame.root;
    }
    TreeFrame frame(std::uint32_t slot) const {
        return is_root(slot) ? rule_.root_frame(slot)
                             : Rule::child_frame(records_[record_of(slot)].frame, number(slot));
    }
    /// The node across a side, also if a crease lies along the side.
    Across beyond(std::uint32_t slot, int side) const;
    /// The same, but a crease is a boundary.
    Across across(std::uint32_t slot, int side) const {
        return is_crease(slot, side) ? Across{k_boundary, 0} : beyond(slot, side);
    }
    /// Whether a crease lies along the side.
    bool is_crease(std::uint32_t slot, int side) const { return (creases(slot) >> side & 1) != 0; }
    unsigned creases(std::uint32_t slot) const {
        if constexpr (!Rule::k_creases) return 0;
        return frame(slot).flags;
    }
    static unsigned creases(const Record& record) { return Rule::k_creases ? record.frame.flags : 0u; }
    /// Calls visit(slot) for the nodes of the same vertex on the other sides of creases: from crease to crease until
    /// this returns to the node; else in both directions to the last crease.
    template <class Visit>
    void for_each_other_side(std::uint32_t slot, Visit&& visit) const;
    /// With points: the corners of a node, and the midpoint that hangs on a side, or none.
    std::array<std::uint32_t, 3> corners(std::uint32_t slot) const requires Rule::k_midpoints {
        return is_root(slot) ? rule_.root_corners(slot)
                             : Rule::child_corners(records_[record_of(slot)].point, number(slot));
    }
    std::uint32_t hanging_point(std::uint32_t slot, int side) const requires Rule::k_midpoints {
        const Across next = beyond(slot, side);
        if (next.slot >= k_coarser || !is_split(next.slot)) return PointId::none;
        return records_[child_[next.slot]].point[3 + next.side];
    }

    Rule rule_;
    std::uint32_t root_count_ = 0, leaf_count_ = 0, point_count_ = 0;
    detail::PoolVector<std::uint32_t> child_;  // per slot: its record, or k_unsplit, or k_dead
    detail::PoolVector<Record> records_;
    detail::PoolVector<Site> sites_;  // per point, canonical; without root: free
    std::vector<std::uint32_t> free_records_, free_points_;
    detail::PoolVector<std::uint8_t> marks_;  // per slot, used during a call; zero between calls

  private:
    void mark_closure(std::span<const LeafId> marked, detail::PoolVector<std::uint32_t>& splits);
    void split(std::uint32_t slot, ForestChange& change);
    bool has_finer_beside(const Record& record) const;
    void remove_records(std::span<const std::uint32_t> going, std::vector<LeafId>& reshaped);
    void append_leaves(std::uint32_t slot, std::vector<LeafId>& leaves) const;
};

// Inline because refinement and output spend most of their time here.

template <class Rule>
inline typename TreeForest<Rule>::Across TreeForest<Rule>::beyond(std::uint32_t slot, int side) const {
    if (is_root(slot)) {
        const std::uint32_t link = rule_.root_link(slot, side);
        return link == k_boundary ? Across{k_boundary, 0} : Across{link / 4, static_cast<int>(link % 4)};
    }
    const std::uint32_t record = record_of(slot);
    const int child = number(slot);
    const auto [sibling, its_side] = Rule::inside(child, side);
    if (sibling < 4) return {first_child(record) + static_cast<std::uint32_t>(sibling), its_side};
    const std::uint32_t link = records_[record].link[side];
    if (link >= k_coarser) return {link, 0};
    // Side s has the children s and s + 1 beside it; seen from the other side, their order is reversed.
    const int other = static_cast<int>(link % 4);
    return {first_child(link / 4) + static_cast<std::uint32_t>(child == side ? next_side(other) : other), other};
}

template <class Rule>
template <class Visit>
void TreeForest<Rule>::for_each_other_side(std::uint32_t slot, Visit&& visit) const {
    if (creases(slot) == 0) return;
    for (int side = 0; side < k_sides; ++side) {
        int out = side;
        for (std::uint32_t at = slot; out >= 0 && is_crease(at, out);) {
            const Across next = beyond(at, out);
            if (next.slot == slot) return;
            visit(next.slot);
            at = next.slot;
            const unsigned other = creases(at) & ~(1u << next.side);
            out = other == 0 ? -1 : std::countr_zero(other);
        }
    }
}

}  // namespace tetrakis
