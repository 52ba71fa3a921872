#pragma once

#include "../base/ids.hpp"
#include "vertex_roots.hpp"

#include <array>
#include <bit>
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
    /// A leaf that is a vertex on a crease, seen from another side than that of its `leaves` entry.
    struct OtherSide {
        std::uint32_t vertex;
        LeafId leaf;
    };

    /// A leaf where a face is: by a corner of its cell, or, in a coarser one, in the middle of a side.
    struct Corner {
        static constexpr std::uint8_t k_on_side = 4;  ///< and the number of the side

        LeafId leaf;  ///< on a crease that on the face's side
        std::uint8_t at;
    };

    std::vector<std::uint32_t> face_offsets{0};  ///< F + 1
    std::vector<std::uint32_t> face_vertices;    ///< numbers into `cells`, counter-clockwise
    std::vector<FaceId> control_faces;           ///< per face
    /// Per face whether a quad's diagonal in the 4-8 pattern starts at its first vertex (else at its second).
    std::vector<std::uint8_t> diagonal_at_first;
    std::vector<VertexCell> cells;       ///< per vertex; on creases, of the side with the lowest root
    std::vector<LeafId> leaves;          ///< per vertex; likewise
    std::vector<Corner> corners;         ///< per face corner, where asked for
    std::vector<OtherSide> other_sides;  ///< in the order of their leaves
};

enum class FaceCorners {
    vertices,  ///< DualFaces::face_vertices alone
    leaves,    ///< DualFaces::corners as well
};

/// Restricted quadtrees of vertices, for dual schemes: a vertex is a cell, and refining it puts its four children in
/// its place, all together. Cells that share a side (or part of it) differ by at most one level.
///
/// The mesh is the dual of the cells: a vertex for each leaf, an edge for each side that two leaves share, a face for
/// each point where leaves meet. Four equal leaves make a quad; where a corner of two leaves lies on the side of a
/// coarser one, the face is a triangle. It never cracks, because nothing in it is cut: it only has other faces. A face
/// belongs to the control face that most of its leaves do (a coarser one counts twice), the first of several; those of
/// holes are left out.
///
/// Along a crease a vertex has a leaf on each side: these are split and merged together, so that both sides have the
/// same vertices there, and are one vertex of the mesh.
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
    /// The leaves across a side: none (both invalid) where the surface ends or a crease runs, one, or two in the order
    /// along the side.
    std::array<LeafId, 2> neighbours(LeafId leaf, int side) const;
    /// The same vertex' leaf on the other side of the crease along a side; invalid where none runs there.
    LeafId across_crease(LeafId leaf, int side) const;
    /// Of the leaves that are the same vertex, the one of the lowest root; the leaf itself away from creases.
    LeafId vertex_leaf(LeafId leaf) const;
    /// Appends the other leaves that are the same vertex: none away from creases.
    void add_other_sides(LeafId leaf, std::vector<LeafId>& leaves) const;
    /// Appends the leaves around a corner of a leaf, itself among them, counter-clockwise: the vertices of the face
    /// there. Nothing where the surface ends or a crease runs.
    void add_leaves_around(LeafId leaf, int corner, std::vector<LeafId>& leaves) const;
    /// All leaves by root, then along the tree's curve (children counter-clockwise from corner 0). O(slots).
    std::vector<LeafId> ordered_leaves() const;

    /// Splits the marked leaves and whatever else has to be, each once: the smallest such refinement. Along creases the
    /// leaves of the other sides are split as well.
    /// @param marked   leaves in any order; repetitions do no harm
    /// @param created  receives the new leaves, four for each split one, siblings together
    /// @param removed  if not null, receives the leaves that were split, siblings' parents in the order of `created`
    /// @throws Error   invalid_input: a handle is no leaf; unsupported: a marked leaf is at level k_max_level;
    ///                 memory_limit: more than 2^32 cells. The forest is then unchanged.
    /// Cost: O(cells split). The slots depend on the set of marked leaves and the calls before, on nothing else.
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& created, std::vector<LeafId>* removed = nullptr);

    /// The leaf and its three siblings, and those with the same parent vertex on the other sides of its creases, if
    /// they are leaves whose merge is allowed; empty otherwise.
    std::vector<LeafId> mergeable_siblings(LeafId leaf) const;
    /// Merges as many of the groups of all siblings that are marked completely as may be, all at once (a set of merges
    /// may be possible where no single one is): the inverse of refine(). Groups of one parent vertex go together.
    /// @param created  receives the parents
    /// @throws Error   invalid_input: a handle is no leaf. The forest is then unchanged.
    void coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created);

    /// O(leaves).
    DualFaces faces(FaceCorners corners = FaceCorners::vertices) const;

    /// Verifies links, counts, the restriction, and that creases have the same vertices on either side. Returns the
    /// first violation, or nothing.
    std::optional<std::string> check() const;
    std::uint64_t memory_bytes() const;
    /// Gives back the memory that the next change would use again, but for that of free slots: what remains
    /// keeps its numbers. O(leaves).
    void shrink();
    /// Whether there are any.
    bool has_free_slots() const { return !free_records_.empty(); }

  private:
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
        std::uint8_t level;    ///< of the cell, not of its children
        std::uint8_t creases;  ///< of the cell's sides, as VertexRoots::crease
    };
    static_assert(sizeof(Record) == 36);

    struct Across {
        std::uint32_t slot;  ///< the cell of the same level across a side; or k_coarser, k_boundary
        int side;            ///< that side, seen from there
    };

    bool is_split(std::uint32_t slot) const { return child_[slot] < k_dead; }
    std::uint32_t first_child(std::uint32_t record) const { return roots_.count() + 4 * record; }
    bool is_root(std::uint32_t slot) const { return slot < roots_.count(); }
    std::uint32_t root_of(std::uint32_t slot) const { return is_root(slot) ? slot : records_[record_of(slot)].root; }
    std::uint32_t record_of(std::uint32_t slot) const { return (slot - roots_.count()) / 4; }
    int number(std::uint32_t slot) const { return static_cast<int>((slot - roots_.count()) % 4); }
    /// The cell beyond a side, on the crease's other side where one runs along it.
    Across beyond(std::uint32_t slot, int side) const;
    /// The same, but for creases, which are boundaries here.
    Across across(std::uint32_t slot, int side) const {
        return is_crease(slot, side) ? Across{k_boundary, 0} : beyond(slot, side);
    }
    /// The sides that lie along creases.
    std::uint8_t creases(std::uint32_t slot) const {
        if (is_root(slot)) return roots_.crease[slot];
        // A child has two of its parent's sides.
        const int child = number(slot);
        return static_cast<std::uint8_t>(records_[record_of(slot)].creases & (1u << child | 1u << (child + 3) % 4));
    }
    bool is_crease(std::uint32_t slot, int side) const { return (creases(slot) >> side & 1) != 0; }
    /// Calls visit(slot) for the other cells that are the same vertex.
    template <class Visit>
    void for_each_other_side(std::uint32_t slot, Visit&& visit) const;
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
        int coarse_side;       ///< that side
    };
    Turn turn(std::uint32_t slot, int corner) const;
    struct FaceList;
    class FaceFinder;

    void require_leaves(std::span<const LeafId> leaves) const;
    void link_record(std::uint32_t record);
    bool has_finer_beside(std::uint32_t record) const;
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

// From side to side along the creases that end at the vertex: around it, or both ways to where that ends.
template <class Visit>
void VertexForest::for_each_other_side(std::uint32_t slot, Visit&& visit) const {
    if (creases(slot) == 0) return;
    for (int side = 0; side < 4; ++side) {
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
