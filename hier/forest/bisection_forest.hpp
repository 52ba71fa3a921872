#pragma once

#include "../base/memory.hpp"
#include "../mesh/control_mesh.hpp"
#include "../mesh/fan_choice.hpp"
#include "bisection_path.hpp"
#include "exported_triangles.hpp"
#include "site.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrakis {

namespace detail {}

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

    BisectionShape shape() const { return {apex, direction}; }
};
static_assert(sizeof(BisectionLeaf) == 48);

/// The restricted 4-8 bisection forest over a polygon mesh: one root (v, w, c) per half-edge v -> w of a face with
/// centre c that is not a hole. Leaves only, in a pool of 48-byte records.
///
/// It is conforming at all times: a leaf is split together with its neighbour across the base edge, which is itself
/// split first where it is one bisection coarser; towards boundary and holes a leaf is split alone. So neighbours
/// across an edge differ by at most one bisection.
///
/// Slots: a leaf keeps its slot until it is split or merged; its child 0 takes the slot over, and a merge gives it
/// back. Root h is born in slot h. Slots of merged leaves are used again. Points: the V control vertices, then the F
/// face centres by their numbers, then midpoints; freed by merges and used again.
class BisectionForest {
  public:
    /// All roots as leaves. Keeps a reference to the mesh. O(H).
    /// @throws Error memory_limit: more vertices and faces than points can be numbered
    explicit BisectionForest(const ControlMesh& mesh);
    explicit BisectionForest(const ControlMesh&&) = delete;

    const ControlMesh& mesh() const { return *mesh_; }

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

    /// Splits the marked leaves and whatever keeps the forest conforming: the smallest such refinement, each leaf once.
    /// @param marked   leaves; repetitions do no harm
    /// @param created  receives all new leaves (of several splits of one leaf, the last ones): for each marked leaf in
    ///                 order its own, then those of the closure that it is the first to need; the descendants of one
    ///                 old leaf in path order
    /// @throws Error   invalid_input: a handle is no leaf; unsupported: a marked leaf is at depth
    ///                 k_max_bisection_depth; memory_limit: more than 2^32 - 1 slots. The forest is then unchanged.
    /// Cost: O(leaves created); parallel. The result (slots and points included) depends on `marked` and the calls
    /// before, not on the number of threads.
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& created);
    /// refine() of one leaf. Returns the number of leaves created.
    std::size_t split(LeafId id);

    /// Whether the leaf is one of the two (at the boundary) or four around a midpoint that is the apex of all of them.
    bool can_merge(LeafId id) const;
    /// Merges these two or four leaves to one or two: the exact inverse of splitting those. Returns these parents, that
    /// of the lowest slot first; the second is invalid at the boundary.
    /// @throws Error  invalid_input: not a leaf, or can_merge() is false. The forest is then unchanged.
    std::array<LeafId, 2> merge(LeafId id);
    /// merge() of all diamonds whose two or four leaves are all marked; other leaves are left alone. Returns their
    /// number.
    /// @param marked   leaves; repetitions do no harm
    /// @param created  receives the parents, those of a diamond together, in the order of the diamonds' lowest slots
    ///                 in `marked`
    /// @throws Error   invalid_input: a handle is no leaf. The forest is then unchanged.
    std::size_t coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created);

    /// All leaves by root, then by path. O(leaves log leaves), parallel.
    std::vector<LeafId> ordered_leaves() const;
    /// The output mesh. O(leaves log leaves), parallel but for the numbering.
    ExportedTriangles exported() const;
    /// The same, but faces with use[f] != 0 whose roots are all unsplit are output as their fans, in the place of their
    /// first root.
    /// @param use  F flags, zero where fans has no triangulation
    ExportedTriangles exported(const FanChoice& fans, std::span<const std::uint8_t> use) const;
    detail::PooledTriangles pooled() const;  ///< exported()

    /// Verifies links, shapes, points, sites, counts and coverage. Returns the first violation, or nothing. O(leaves).
    std::optional<std::string> check() const;

    /// Bytes allocated: after shrink() 48 a slot, and a site of 16 for each slot of points.
    std::uint64_t memory_bytes() const;
    /// Gives back the memory that the next change would use again, but for that of free slots and points: what remains
    /// keeps its numbers. O(leaves).
    void shrink();
    /// Whether there are any.
    bool has_free_slots() const { return !free_leaves_.empty() || !free_points_.empty(); }

  private:
    static constexpr std::uint8_t k_dead = 0xFF;  // depth of a slot that holds no leaf

    // What a slot is to the running call. In one record, because neighbours ask for all of it at once.
    struct Work {
        // Places among the new leaves and points, in the order of allocation; while the closure is sought, `first_leaf`
        // is the number of the first marked leaf that leads here.
        std::uint32_t first_leaf = LeafId::none, midpoint = PointId::none;
        std::uint8_t mark = 0;              // not zero: the leaf is split (or merged)
        std::uint8_t base = 0;              // what split_base() says
        std::array<std::uint8_t, 2> leg{};  // whether edges 1 and 2 get a midpoint
    };
    static_assert(sizeof(Work) == 12);
    // Memory kept from call to call; a copy of a forest starts without.
    struct Scratch {
        Scratch() = default;
        Scratch(const Scratch&) {}
        Scratch(Scratch&&) = default;
        Scratch& operator=(const Scratch&) { return *this; }
        Scratch& operator=(Scratch&&) = default;
        detail::PodArray<Work> work;                       // per slot; Work{} between calls
        detail::PodArray<std::uint32_t> listed, affected;  // slots
        std::vector<LeafId> created;
    };
    struct Diamond;
    struct Merge;
    struct SplitWriter;

    void require_leaves(std::span<const LeafId> ids) const;
    struct SplitSums;
    bool is_splittable(LeafId id) const { return is_leaf(id) && depth(id) < k_max_bisection_depth; }
    void require_splittable(LeafId id) const;
    void list_marked(std::span<const LeafId> marked, bool parallel);
    void prefetch_bases(std::uint32_t i) const;
    bool claim_bases();
    SplitSums plan_serially();
    SplitSums plan_in_parallel(std::span<const LeafId> marked);
    void reserve_for(std::uint64_t new_leaves, std::uint64_t new_points);
    void grow_work(std::size_t slots);
    void clear_work();
    std::uint32_t edge_towards(std::uint32_t slot, std::uint32_t neighbour) const {
        const auto& n = leaves_[slot].neighbour;
        return n[0].value == neighbour ? 0 : n[1].value == neighbour ? 1 : 2;
    }
    std::uint32_t new_leaf_slot(std::uint32_t i) const {
        const auto reused = static_cast<std::uint32_t>(free_leaves_.size());
        return i < reused ? free_leaves_[reused - 1 - i] : leaf_top_ + (i - reused);
    }
    std::uint32_t new_point_slot(std::uint32_t i) const {
        const auto reused = static_cast<std::uint32_t>(free_points_.size());
        return i < reused ? free_points_[reused - 1 - i] : point_top_ + (i - reused);
    }
    bool find_diamond(std::uint32_t slot, Diamond& diamond) const;
    std::size_t find_marked_diamonds(std::span<const std::uint32_t> unique,
                                     detail::PoolVector<Diamond>& diamonds) const;
    void merge_diamonds(std::span<const Diamond> diamonds, std::span<Merge> merges, std::span<LeafId> created);
    void prefetch_beyond(const Diamond& diamond) const;
    Merge plan_merge(const Diamond& diamond, std::uint32_t pair) const;
    detail::PoolVector<std::uint32_t> leaves_in_order() const;
    template <class Exported>
    void export_to(Exported& out, const FanChoice& fans, std::span<const std::uint8_t> use) const;
    std::optional<std::string> check_leaf(std::uint32_t slot) const;
    std::optional<std::string> check_pool() const;

    const ControlMesh* mesh_;
    std::uint32_t leaf_count_ = 0, midpoint_count_ = 0;
    std::uint32_t leaf_top_ = 0, point_top_ = 0;  // slots before the running call's allocation
    detail::PodArray<BisectionLeaf> leaves_;
    detail::PodArray<Site> sites_;  // per point, canonical; no root: not in use
    std::vector<std::uint32_t> free_leaves_, free_points_;
    Scratch scratch_;
};

}  // namespace tetrakis
