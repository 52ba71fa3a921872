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
    std::uint8_t mark;                ///< state during refine() and coarsen(); else zero

    BisectionShape shape() const { return {apex, direction}; }
};
static_assert(sizeof(BisectionLeaf) == 48);

/// The leaves whose apex is one common midpoint: children of two leaves with a shared base, or of one leaf whose base
/// is on the boundary or beside a hole. Child 0 takes its parent's slot. So a split removes the leaves `pairs[i][0]`
/// and creates all of `pairs`; a merge does the reverse.
struct Diamond {
    PointId midpoint;                              ///< created by the split, removed by the merge
    std::uint32_t pair_count = 0;                  ///< 1 or 2
    std::array<std::array<LeafId, 2>, 2> pairs{};  ///< children 0 and 1 of each parent, by increasing slot of child 0

    std::span<const std::array<LeafId, 2>> siblings() const { return std::span(pairs).first(pair_count); }
};

/// The restricted 4-8 bisection forest over a polygon mesh: one root (v, w, c) per half-edge v -> w of a face with
/// centre c that is not a hole. Only leaves are stored, in a pool of 48-byte records.
///
/// The forest is conforming at all times. A leaf is split together with its neighbour across the base edge; a neighbour
/// that is one bisection coarser is split before. At the boundary and beside holes a leaf is split alone. So neighbours
/// across an edge differ by at most one bisection.
///
/// split_diamond() and merge_diamond() change one diamond at a time, are exact inverses and never allocate. refine()
/// and coarsen() do the same for many leaves. All changes but fold_diamond() are made by one thread.
///
/// Slots: a leaf keeps its slot until it is split or merged; a split passes the slot to child 0, and a merge returns it
/// to the parent. Root h starts in slot h. The slot freed last is reused first. Point numbers: the V control vertices,
/// the F face centres in face order, then midpoints, whose numbers are reused in the same way.
class BisectionForest {
  public:
    /// All roots as leaves. Keeps a reference to the mesh. O(H).
    /// @throws Error memory_limit: more vertices and faces than points can be numbered
    explicit BisectionForest(const ControlMesh& mesh);
    explicit BisectionForest(const ControlMesh&&) = delete;

    const ControlMesh& mesh() const { return *mesh_; }

    /// Makes all roots leaves again and keeps the allocated room. O(H)
    void clear();

    /// All leaf numbers are below this number; some of the slots may hold no leaf.
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
    /// The leaf that is the whole root triangle of h; invalid where that is split, or part of a hole.
    LeafId root_leaf(HalfedgeId h) const { return leaves_[h.value].depth == 0 ? LeafId(h.value) : LeafId{}; }
    CellTriangle triangle(LeafId id) const {
        const BisectionLeaf& l = leaves_[id.value];
        return l.shape().in(l.cell, l.depth);
    }

    /// All point numbers are below this number; some of the slots may hold no point.
    std::uint32_t point_slots() const { return static_cast<std::uint32_t>(sites_.size()); }
    bool is_point(PointId p) const { return p.value < sites_.size() && sites_[p.value].root.valid(); }
    /// Number of midpoints that splits have created and no merge has removed.
    std::uint32_t midpoint_count() const { return midpoint_count_; }
    /// The canonical site of a point (corner_cell.hpp); its root is invalid for free slots and isolated vertices.
    const Site& point_site(PointId p) const { return sites_[p.value]; }
    PointId vertex_point(VertexId v) const { return PointId(v.value); }
    PointId centre_point(FaceId f) const { return PointId(mesh_->vertex_count() + f.value); }

    /// Makes room for `leaves` leaves in total. The first overload makes room for a midpoint of each leaf beyond the
    /// roots, the second for `midpoints` midpoints.
    /// @throws Error  memory_limit: more than 2^32 - 1 slots. The forest is then unchanged.
    void reserve(std::uint32_t leaves) { reserve(leaves, leaves > root_count_ ? leaves - root_count_ : 0); }
    void reserve(std::uint64_t leaves, std::uint64_t midpoints);
    /// Has the system map the pages of the reserved room, so that no split waits for one.
    void map_room();
    /// Largest number of leaves that split_diamond() may reach. reserve() and refine() raise it, shrink() lowers it.
    std::uint32_t leaf_capacity() const { return leaf_capacity_; }

    /// Numbers of leaves and midpoints that split_diamond() adds; each diamond split adds one midpoint.
    struct SplitCost {
        std::uint64_t leaves = 0, midpoints = 0;
    };
    /// @throws Error  unsupported: the leaf is at depth k_max_bisection_depth
    SplitCost split_cost(LeafId id) const;

    /// Splits a leaf with its neighbour across the base, after the coarser leaves that must be split before them.
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

    /// The diamond that merge_diamond() would merge; it has no pairs where can_merge() is false.
    Diamond find_diamond(LeafId id) const;
    /// Whether the leaf is part of a diamond whose two leaves (at the boundary or a hole) or four all exist.
    bool can_merge(LeafId id) const { return is_leaf(id) && find_diamond(id).pair_count > 0; }
    /// Merges the leaves of the diamond into one or two, then calls changed(diamond). O(1), allocates nothing.
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

    /// Moves the leaf in the last slot to a free slot and drops the free slots at the end, so that leaf_slots() falls.
    /// The slots of the roots stay. O(1 + slots dropped); allocates nothing.
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

    /// merge_diamond() in two steps, for threads that merge different diamonds at the same time. fold_diamond() writes
    /// the leaves of the diamond and those across its four sides; no other thread may access these meanwhile.
    /// free_folded() frees the slots; one thread calls it.
    /// @param diamond  a result of find_diamond() that has not been merged since
    void fold_diamond(const Diamond& diamond);
    void free_folded(const Diamond& diamond);

    /// Applies split_diamond() to the marked leaves in turn, but not to those that are split by then: the smallest
    /// conforming refinement that splits each of them. Makes room for it.
    /// @param marked   leaves, not in `created`; repetitions do no harm
    /// @param created  receives all new leaves that remain (a leaf may be split twice): descendants of the marked
    ///                 leaves, in the order of these, then those of the other split leaves; in path order within a leaf
    /// @throws Error   unsupported: a marked leaf is at depth k_max_bisection_depth; memory_limit: more than 2^32 - 1
    ///                 slots. The forest is then unchanged.
    /// Cost: O(leaves created).
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& created);
    /// Merges all diamonds whose two or four leaves are all marked; other leaves stay. Goes through `marked` from its
    /// end, so that the slots of leaves created by refine() are freed in reverse order.
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

    // Members that check_forest() (check.hpp) uses.
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
    /// Whether p is a control vertex or a face centre: these are points whatever the leaves are.
    bool is_fixed(PointId p) const { return p.value < fixed_points(); }

    /// Bytes allocated: 48 for each leaf that there is room for, and 16 for each point.
    std::uint64_t memory_bytes() const;
    /// Frees the room beyond the last leaf and point slots. Leaves and points keep their numbers. O(leaves).
    void shrink();
    /// Whether some slots of leaves or points are free.
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
    LeafId free_leaf_;              // slot freed last. A free slot's neighbour[0] was freed before it, [1] after it
    PointId free_point_;            // point freed last; at.x of its site is the point freed before it
};

}  // namespace tetrakis
