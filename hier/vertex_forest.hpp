#pragma once

#include "tetrakis/hier/ids.hpp"
#include "tetrakis/hier/vertex_roots.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace tetrakis {

/// The mesh that a VertexForest's leaves are the vertices of, in (root, path) order: the same for the same set of
/// leaves.
struct DualFaces {
    std::vector<std::uint32_t> face_offsets{0};  ///< F + 1
    std::vector<std::uint32_t> face_vertices;    ///< numbers into `cells`, counter-clockwise
    std::vector<FaceId> control_faces;           ///< per face
    /// Per face whether a quad's diagonal in the 4-8 pattern starts at its first vertex (else at its second).
    std::vector<std::uint8_t> diagonal_at_first;
    std::vector<VertexCell> cells;  ///< per vertex
    std::vector<LeafId> leaves;     ///< per vertex
};

/// Restricted quadtrees of vertices, for dual schemes: a vertex is a cell, and refining it puts its four children in
/// its place, all together. Cells that share a side (or part of it) differ by at most one level.
///
/// The mesh is the dual of the cells: a vertex for each leaf, an edge for each side that two leaves share, a face for
/// each point where leaves meet. Four equal leaves make a quad; where a corner of two leaves lies on the side of a
/// coarser one, the face is a triangle. It never cracks, because nothing in it is cut: it only has other faces. Faces
/// none of whose leaves belongs to the surface (VertexRoots::hole) are left out.
///
/// Storage: a record of 36 bytes per split cell, which is a third of the leaves, plus 5 bytes per cell: 19 bytes a
/// leaf. Slots: the root r is slot r, the children of the k-th record are R + 4 k + corner. Slots are used again after
/// a merge.
class VertexForest {
  public:
    /// The roots as leaves. O(roots).
    explicit VertexForest(VertexRoots roots);

    const VertexRoots& roots() const { return roots_; }

    /// Leaves are numbered below this; not all of these numbers are leaves.
    std::uint32_t leaf_slots() const { return static_cast<std::uint32_t>(child_.size()); }
    bool is_leaf(LeafId leaf) const { return leaf.value < child_.size() && child_[leaf.value] == k_unsplit; }
    std::uint32_t leaf_count() const { return leaf_count_; }
    int level(LeafId leaf) const;
    VertexCell cell(LeafId leaf) const;
    /// The leaves across a side: none (both invalid) where the surface ends, one, or two in the order along the side.
    std::array<LeafId, 2> neighbours(LeafId leaf, int side) const;
    /// Appends the leaves around a corner of a leaf, itself among them, counter-clockwise: the vertices of the face
    /// there. Nothing where the surface ends.
    void add_leaves_around(LeafId leaf, int corner, std::vector<LeafId>& leaves) const;
    /// All leaves by root, then along the tree's curve (children counter-clockwise from corner 0). O(slots).
    std::vector<LeafId> ordered_leaves() const;

    /// Splits the marked leaves and whatever else has to be, each once: the smallest such refinement.
    /// @param marked   leaves in any order; repetitions do no harm
    /// @param created  receives the new leaves, four for each split one, siblings together
    /// @param removed  if not null, receives the leaves that were split, siblings' parents in the order of `created`
    /// @throws Error   invalid_input: a handle is no leaf; unsupported: a marked leaf is at level k_max_level;
    ///                 memory_limit: more than 2^32 cells. The forest is then unchanged.
    /// Cost: O(cells split). The slots depend on the set of marked leaves and the calls before, on nothing else.
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& created, std::vector<LeafId>* removed = nullptr);

    /// The leaf and its three siblings if they are leaves whose merge is allowed; empty otherwise.
    std::vector<LeafId> mergeable_siblings(LeafId leaf) const;
    /// Merges as many of the groups of four siblings that are marked completely as may be, all at once (a set of merges
    /// may be possible where no single one is): the inverse of refine().
    /// @param created  receives the parents
    /// @throws Error   invalid_input: a handle is no leaf. The forest is then unchanged.
    void coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created);

    /// O(leaves).
    DualFaces faces() const;

    /// Verifies links, counts and the restriction. Returns the first violation, or nothing.
    std::optional<std::string> check() const;
    std::uint64_t memory_bytes() const;

  private:
    friend struct VertexForestCorruptor;  // of the tests

    static constexpr std::uint32_t k_unsplit = 0xFFFF'FFFFu;   // child_: a leaf
    static constexpr std::uint32_t k_dead = 0xFFFF'FFFEu;      // child_: a child of a record that is not in use
    static constexpr std::uint32_t k_coarser = 0xFFFF'FFFEu;   // links: there is no cell, or record, of this level
    static constexpr std::uint32_t k_boundary = 0xFFFF'FFFFu;  // links: the surface ends (VertexRoots::outside)
    static constexpr std::uint64_t k_max_slots = 0xFFFF'FFF0u;

    /// A split cell.
    struct Record {
        std::array<std::uint32_t, 4> link;  ///< across side s: 4 * record + its side; k_coarser, k_boundary
        std::uint32_t parent;               ///< the cell's slot
        std::uint32_t root;
        LatticePoint at;
        std::uint8_t level;  ///< of the cell, not of its children
    };
    static_assert(sizeof(Record) == 36);

    struct Across {
        std::uint32_t slot;  ///< the cell of the same level across a side; or k_coarser, k_boundary
        int side;            ///< that side, seen from there
    };

    bool is_split(std::uint32_t slot) const { return child_[slot] < k_dead; }
    std::uint32_t first_child(std::uint32_t record) const { return roots_.count() + 4 * record; }
    bool is_root(std::uint32_t slot) const { return slot < roots_.count(); }
    std::uint32_t record_of(std::uint32_t slot) const { return (slot - roots_.count()) / 4; }
    int number(std::uint32_t slot) const { return static_cast<int>((slot - roots_.count()) % 4); }
    Across across(std::uint32_t slot, int side) const;
    /// The leaf at a corner of a cell.
    std::uint32_t leaf_at(std::uint32_t slot, int corner) const {
        while (is_split(slot)) slot = first_child(child_[slot]) + static_cast<std::uint32_t>(corner);
        return slot;
    }

    /// Counter-clockwise around the point at a leaf's corner, across the side that ends there.
    struct Turn {
        std::uint32_t slot;    ///< the next leaf that has a corner there; k_boundary where the surface ends
        int corner;            ///< that corner
        std::uint32_t coarse;  ///< the leaf between, in the middle of whose side the point is; k_boundary: none
    };
    Turn turn(std::uint32_t slot, int corner) const;

    void require_leaves(std::span<const LeafId> leaves) const;
    void link_record(std::uint32_t record);
    bool must_stay(std::uint32_t record) const;
    void keep_what_must_stay(std::span<const std::uint32_t> records);
    std::optional<std::string> check_record(std::uint32_t record) const;

    VertexRoots roots_;
    std::uint32_t leaf_count_ = 0;
    std::vector<std::uint32_t> child_;  // per slot: its record, or k_unsplit, k_dead
    std::vector<Record> records_;
    std::vector<std::uint32_t> free_records_;
    std::vector<std::uint8_t> marks_;  // per slot: will be split or merged; zero between calls
};

}  // namespace tetrakis
