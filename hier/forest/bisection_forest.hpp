#pragma once

#include "../base/memory.hpp"
#include "../mesh/control_mesh.hpp"
#include "../mesh/fan_choice.hpp"
#include "bisection_path.hpp"
#include "exported_triangles.hpp"
#include "site.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis {

/// A leaf of the bisection forest: the triangle (a, b, apex), counter-clockwise, with the base edge a-b that its split
/// will bisect. Edge 0 is the base, edge 1 runs from b to the apex, edge 2 from the apex to a.
struct BisectionLeaf {
    std::uint64_t path;  ///< children taken from the root, the first in the most significant of `depth` bits
    HalfedgeId cell;     ///< the corner cell whose frame `shape` is written in
    LatticePoint apex;   ///< at lattice level depth / 2
    std::array<LeafId, 3> neighbour;  ///< the leaf across each edge; invalid on the boundary and towards holes
    std::array<PointId, 3> vertex;    ///< a, b, apex
    std::uint8_t depth;               ///< number of bisections
    std::uint8_t direction;           ///< as BisectionShape::direction
    std::uint8_t mark;                ///< of a running batch; else zero

    BisectionShape shape() const { return {apex, direction}; }
};
static_assert(sizeof(BisectionLeaf) == 48);

/// The leaves around a midpoint that is the apex of all of them: the children of two leaves that share their base, or
/// of one whose base is on the boundary or beside a hole. Child 0 has the slot of its parent, so that a split removes
/// the leaves `pairs[i][0]` and creates all of `pairs`, a merge the reverse.
struct Diamond {
    PointId midpoint;                              ///< created by the split, removed by the merge
    std::uint32_t pair_count = 0;                  ///< 1 or 2
    std::array<std::array<LeafId, 2>, 2> pairs{};  ///< children 0 and 1 of each parent; that of the lower slot is first

    std::span<const std::array<LeafId, 2>> siblings() const { return std::span(pairs).first(pair_count); }
};

/// The restricted 4-8 bisection forest over a polygon mesh: one root (v, w, c) per half-edge v -> w of a face with
/// centre c that is not a hole. Leaves only, in a pool of 48-byte records.
///
/// It is conforming at all times: a leaf is split together with its neighbour across the base edge, which is itself
/// split first where it is one bisection coarser; towards boundary and holes a leaf is split alone. So neighbours
/// across an edge differ by at most one bisection.
///
/// split_diamond() and merge_diamond() change one diamond at a time, are exact inverses and never allocate. refine()
/// and coarsen() do the same for many leaves. All changes are made by one thread.
///
/// Slots: a leaf keeps its slot until it is split or merged; its child 0 takes the slot over, and a merge gives it
/// back. Root h is born in slot h. The slot that was freed last is used first. Points: the V control vertices, then the
/// F face centres by their numbers, then midpoints, whose numbers are used again in the same way.
class BisectionForest {
  public:
    /// All roots as leaves. Keeps a reference to the mesh. O(H).
    /// @throws Error memory_limit: more vertices and faces than points can be numbered
    explicit BisectionForest(const ControlMesh& mesh);
    explicit BisectionForest(const ControlMesh&&) = delete;

    const ControlMesh& mesh() const { return *mesh_; }

    /// All roots as leaves again, with the room for more kept. O(H)
    void clear();

    /// Leaves are numbered below this; not all of these numbers are leaves.
    std::uint32_t leaf_slots() const { return static_cast<std::uint32_t>(leaves_.size()); }
    bool is_leaf(LeafId id) const { return id.value < leaves_.size() && leaves_[id.value].depth != k_dead; }
    std::uint32_t leaf_count() const { return leaf_count_; }
    const BisectionLeaf& leaf(LeafId id) const { return leaves_[id.value]; }
    int depth(LeafId id) const { return leaves_[id.value].depth; }
    FaceId face(LeafId id) const { return mesh_->face(leaves_[id.value].cell); }
    HalfedgeId root(LeafId id) const {
        const BisectionLeaf& l = leaves_[id.value];
        return l.depth > 0 && (l.path >> (l.depth - 1) & 1) != 0 ? mesh_->prev(l.cell) : l.cell;
    }
    /// The root triangle of h, where it is a leaf; else invalid.
    LeafId root_leaf(HalfedgeId h) const { return leaves_[h.value].depth == 0 ? LeafId(h.value) : LeafId{}; }
    CellTriangle triangle(LeafId id) const {
        const BisectionLeaf& l = leaves_[id.value];
        return l.shape().in(l.cell, l.depth);
    }

    /// Points are numbered below this; not all of these numbers are points.
    std::uint32_t point_slots() const { return static_cast<std::uint32_t>(sites_.size()); }
    bool is_point(PointId p) const { return p.value < sites_.size() && sites_[p.value].root.valid(); }
    /// Points made by splits and not freed.
    std::uint32_t midpoint_count() const { return midpoint_count_; }
    /// The canonical site of a point (corner_cell.hpp); the root is invalid where there is none.
    const Site& point_site(PointId p) const { return sites_[p.value]; }
    PointId vertex_point(VertexId v) const { return PointId(v.value); }
    PointId centre_point(FaceId f) const { return PointId(mesh_->vertex_count() + f.value); }

    /// Makes room for `leaves` leaves in all and their points, of which there may be one for each leaf; the second one
    /// makes room for so many points.
    /// @throws Error  memory_limit: more than 2^32 - 1 slots. The forest is then unchanged.
    void reserve(std::uint32_t leaves) { reserve(leaves, leaves > root_count_ ? leaves - root_count_ : 0); }
    void reserve(std::uint64_t leaves, std::uint64_t midpoints);
    /// The pages of what is reserved are of ordinary size: no split waits for a large one to be cleared.
    void wish_for_small_pages();
    /// split_diamond() makes no more leaves than these. reserve() and refine() raise it.
    std::uint32_t leaf_capacity() const { return leaf_capacity_; }

    /// What split_diamond() adds: leaves, and as many midpoints as diamonds are split.
    struct SplitCost {
        std::uint64_t leaves = 0, midpoints = 0;
    };
    /// @throws Error  unsupported: the leaf is at depth k_max_bisection_depth
    SplitCost split_cost(LeafId id) const;

    /// Splits a leaf with its neighbour across the base, after the coarser leaves that this one asks for, base by base.
    /// @param changed  changed(diamond) is called after each split, the coarsest diamond first
    /// @return  false, with the forest as it was, if there is no room for this
    /// @throws Error  as split_cost(); the forest is then unchanged
    /// Cost: O(diamonds split); allocates nothing.
    template <class Changed>
    bool split_diamond(LeafId id, Changed&& changed) {
        const SplitCost cost = split_cost(id);
        if (cost.leaves > leaf_capacity_ - leaf_count_ || cost.midpoints > midpoint_capacity_ - midpoint_count_)
            return false;
        split_from_base(id, changed);
        return true;
    }

    /// What merge_diamond() would merge with a leaf; without pairs where can_merge() is false.
    Diamond find_diamond(LeafId id) const;
    /// Whether the leaf is one of the two (at the boundary) or four around a midpoint that is the apex of all of them.
    bool can_merge(LeafId id) const { return is_leaf(id) && find_diamond(id).pair_count > 0; }
    /// Merges these two or four leaves to one or two, with changed(diamond) called afterwards. O(1), allocates nothing.
    /// @return  false, with the forest as it was, if can_merge() is false
    template <class Changed>
    bool merge_diamond(LeafId id, Changed&& changed) {
        const Diamond diamond = find_diamond(id);
        if (diamond.pair_count == 0) return false;
        fold_diamond(diamond);
        free_folded(diamond);
        changed(diamond);
        return true;
    }

    /// Moves the leaf in the last slot to a free one, and gives up the slots beyond those in use: leaf_slots() falls.
    /// The slots of roots' first leaves stay. O(1) and what has been freed at the end; allocates nothing.
    /// @param moved  moved(from, to) is called afterwards
    /// @return       false: no slot was free
    template <class Moved>
    bool move_last_leaf(Moved&& moved) {
        drop_last_slots();
        if (!free_leaf_.valid()) return false;
        const LeafId from(leaf_slots() - 1), to = free_leaf_;
        move_leaf(from, to);
        drop_last_slots();
        moved(from, to);
        return true;
    }

    /// merge_diamond() in two steps, for threads that merge apart from each other. The first writes the diamond's
    /// leaves and those across its four sides, at which no other thread may look; the second gives back the slots, and
    /// is for one thread.
    /// @param diamond  that find_diamond() gave, not merged since
    void fold_diamond(const Diamond& diamond);
    void free_folded(const Diamond& diamond);

    /// split_diamond() of the marked leaves in turn, but for those that others have split: the smallest conforming
    /// refinement that splits each of them. Makes room for it.
    /// @param marked   leaves, not in `created`; repetitions do no harm
    /// @param created  receives all new leaves (of several splits of one leaf, the last ones): the descendants of the
    ///                 marked leaves in their order, then those of the other leaves that were split; those of one leaf
    ///                 in path order
    /// @throws Error   unsupported: a marked leaf is at depth k_max_bisection_depth; memory_limit: more than 2^32 - 1
    ///                 slots. The forest is then unchanged.
    /// Cost: O(leaves created).
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& created);
    /// merge_diamond() of all diamonds whose two or four leaves are all marked; other leaves are left alone. The last
    /// of `marked` comes first, so that the slots of what refine() has created are freed in reverse.
    /// @param marked   leaves, not in `created`; repetitions do no harm
    /// @param created  receives the parents, those of a diamond together, in the order of the diamonds' last leaves in
    ///                 `marked`
    /// @return         the number of diamonds
    std::size_t coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created);

    /// All leaves by root, then by path. O(leaves log leaves), parallel.
    std::vector<LeafId> ordered_leaves() const;
    /// The output mesh. Faces with use[f] != 0 whose roots are all unsplit are output as their fans, in the place of
    /// their first root. O(leaves log leaves).
    /// @param use  F flags, zero where fans has no triangulation; empty: no face is
    ExportedTriangles exported(const FanChoice& fans = {}, std::span<const std::uint8_t> use = {}) const;

    // As check_forest() asks.
    static constexpr int k_sides = 3;
    int level(LeafId id) const { return depth(id); }
    std::array<LeafId, 2> neighbours(LeafId id, int side) const {
        return {leaves_[id.value].neighbour[static_cast<std::size_t>(side)], LeafId{}};
    }
    const std::array<PointId, 3>& points(LeafId id) const { return leaves_[id.value].vertex; }
    Site corner_site(LeafId id, int corner) const {
        return tetrakis::corner_site(*mesh_, triangle(id), static_cast<std::size_t>(corner));
    }
    /// Whether the surface ends at a side: on the boundary, or towards a hole.
    bool ends_at(LeafId id, int side) const {
        const CellTriangle t = triangle(id);
        const auto k = static_cast<std::size_t>(side);
        const LatticePoint p = t.corner[k], q = t.corner[(k + 1) % 3];
        const HalfedgeId h = p.y == 0 && q.y == 0 ? t.root : p.x == 0 && q.x == 0 ? mesh_->prev(t.root) : HalfedgeId{};
        return h.valid() && (!mesh_->twin(h).valid() || mesh_->is_hole(mesh_->face(mesh_->twin(h))));
    }
    /// Control vertices and centres of faces are points for any set of leaves.
    bool is_fixed(PointId p) const { return p.value < fixed_points(); }

    /// Bytes allocated: 48 for each leaf that there is room for, and 16 for each point.
    std::uint64_t memory_bytes() const;
    /// Gives back the room beyond the slots and points in use or freed: what remains keeps its numbers. O(leaves).
    void shrink();
    /// Whether slots or points were freed and not used again.
    bool has_free_slots() const { return free_leaf_.valid() || free_point_.valid(); }

  private:
    static constexpr std::uint8_t k_dead = 0xFF;  // depth of a slot that holds no leaf

    void require_splittable(LeafId id) const;
    std::uint32_t fixed_points() const { return mesh_->vertex_count() + mesh_->face_count(); }
    std::uint32_t hole_slots() const { return mesh_->halfedge_count() - root_count_; }

    // The leaf across the base if it is coarser, and so has to be split first; else invalid.
    LeafId coarser_base(LeafId id) const {
        const BisectionLeaf& l = leaves_[id.value];
        return l.neighbour[0].valid() && depth(l.neighbour[0]) < l.depth ? l.neighbour[0] : LeafId{};
    }
    template <class Changed>
    void split_from_base(LeafId id, Changed& changed) {
        if (const LeafId coarser = coarser_base(id); coarser.valid()) split_from_base(coarser, changed);
        changed(bisect(id));
    }
    Diamond bisect(LeafId id);
    LeafId take_leaf();
    void free_leaf(LeafId slot);
    void take_free_leaf(LeafId slot);
    void move_leaf(LeafId from, LeafId to);
    void drop_last_slots();
    PointId take_point(const Site& site);
    void relink(LeafId leaf, LeafId from, LeafId to);
    SplitCost mark_closure(std::span<const LeafId> marked, std::vector<LeafId>& list);

    const ControlMesh* mesh_;
    std::uint32_t root_count_ = 0;
    std::uint32_t leaf_count_ = 0, leaf_capacity_ = 0;
    std::uint32_t midpoint_count_ = 0, midpoint_capacity_ = 0;
    detail::PodArray<BisectionLeaf> leaves_;
    detail::PodArray<Site> sites_;  // per point, canonical; no root: not in use
    LeafId free_leaf_;              // the slot freed last; neighbour[0] is the one freed before it, [1] the one after
    PointId free_point_;            // the same; the one before it is at.x of its site
};

}  // namespace tetrakis
