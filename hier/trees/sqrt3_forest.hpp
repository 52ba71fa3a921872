#pragma once

#include "../base/ids.hpp"
#include "../base/memory.hpp"
#include "../forest/exported_triangles.hpp"
#include "sqrt3_lattice.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace tetrakis {

/// Adaptive sqrt(3) refinement (Kobbelt 2000, section 5, adaptive refinement): a split inserts a point in a face, and
/// an edge is flipped as soon as both of its faces are split. The flipped triangle is a face of the next level and can
/// be split itself. So a face exists when the faces on both sides of the edge that it crosses are split; the mesh is
/// conforming and graded. Edges that are not flipped (Sqrt3Lattice: boundary, creases, kept ones) are cut in three by
/// every second step. There both faces of an interior edge are split together, as partners.
///
/// A split replaces a triangle by three, over its edges. If the triangle across an edge is whole, the new one over the
/// edge is a half; else it is whole, and the half across the edge becomes whole, too. Splitting a half triangle splits
/// the triangle across its edge. The group of a split is what it changed: its three triangles, and the ones that became
/// whole across its edges. If it cuts an edge, which it does from both sides, the group is that of both splits.
///
/// The face across an edge is found from the lattice's numbers, from the root down. Storage: some 16 bytes a leaf. Face
/// r has slot r; triangles over the edges of the k-th split triangle have slots F + 3 k + side. Const calls are safe
/// from several threads.
class Sqrt3Forest {
  public:
    /// Starts with the control faces as leaves, without holes. Keeps a reference.
    /// @param kept    as for Sqrt3Lattice
    /// @throws Error  unsupported: a face is not a triangle
    explicit Sqrt3Forest(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept = {});
    explicit Sqrt3Forest(const ControlMesh&&, const std::function<bool(EdgeId)>& = {}) = delete;

    const ControlMesh& mesh() const { return lattice_.mesh(); }
    /// The lattice without stored twins; copy it before use.
    const Sqrt3Lattice& lattice() const { return lattice_; }
    /// The deepest level: its triangles cannot be split.
    int max_level() const { return Sqrt3Lattice::max_level(mesh()); }
    /// Leaves are numbered below this; some of these numbers are not leaves.
    std::uint32_t leaf_slots() const { return static_cast<std::uint32_t>(child_.size()); }
    std::uint32_t leaf_count() const { return root_leaves_ + 2 * split_count(); }
    /// Number of split triangles. Each split adds two leaves, also on the boundary.
    std::uint32_t split_count() const { return static_cast<std::uint32_t>(records_.size() - free_records_.size()); }
    bool is_leaf(LeafId leaf) const { return leaf.value < child_.size() && is_leaf_slot(leaf.value); }
    Sqrt3Triangle triangle(LeafId leaf) const { return triangle_of(leaf.value); }
    int level(LeafId leaf) const { return triangle(leaf).level; }
    bool is_half(LeafId leaf) const { return child_[leaf.value] == k_half; }
    /// The corners of a leaf, counter-clockwise. A point has the same number while it exists, below point_slots().
    std::array<PointId, 3> points(LeafId leaf) const;
    /// The site of a point of the mesh. O(level).
    Site point_site(PointId point) const;
    std::uint32_t point_slots() const {
        return mesh().vertex_count() + 2 * static_cast<std::uint32_t>(records_.size());
    }
    /// The leaf across the side from corner `side` to the next one, invalid at the boundary; the second is invalid.
    /// O(level).
    std::array<LeafId, 2> neighbours(LeafId leaf, int side) const;
    /// All leaves by control face, then by path, depth first.
    std::vector<LeafId> ordered_leaves() const;
    /// Calls visit(leaf, control face) in the order of ordered_leaves().
    template <class Visit>
    void for_each_leaf(Visit&& visit) const {
        for (std::uint32_t root = 0; root < mesh().face_count(); ++root)
            if (child_[root] != k_dead) visit_below(root, FaceId(root), visit);
    }
    std::vector<Sqrt3Triangle> leaves() const;
    /// The output mesh: the leaves in the same order. O(leaves level).
    ExportedTriangles exported() const;
    /// The leaf that is this triangle, or an invalid id. O(level).
    LeafId find(const Sqrt3Triangle& triangle) const;
    using Changed = std::vector<std::pair<LeafId, Sqrt3Triangle>>;
    /// Splits the marked leaves and all that must be split with them. All or nothing.
    /// @param change   receives the new leaves: those over the edges of split triangles, coarsest first, then those
    ///                 that became whole
    /// @param removed  receives leaves that vanished or became whole, as they were before; may be null
    /// @throws Error   unsupported: a leaf is at max_level(); memory_limit. The forest is then unchanged.
    void refine(std::span<const LeafId> marked, ForestChange& change, Changed* removed = nullptr);
    /// Undoes each split whose own triangles (three; six if it cut an edge) are all marked, if all of its group are
    /// leaves.
    /// @param change   receives the triangles that are leaves again, then the triangles that are half again
    /// @param removed  receives, of the latter, the ones that were not marked, as they were before
    void coarsen(std::span<const LeafId> marked, ForestChange& change, Changed& removed);
    /// The own triangles (three; six if it cut an edge) of a split that can be undone because all of its group are
    /// leaves: the split of the triangle that the leaf is over an edge of, else of the one across that edge. Empty if
    /// neither can be.
    std::vector<LeafId> group(LeafId leaf) const;

    // For check_forest().
    static constexpr int k_sides = 3;
    Site corner_site(LeafId leaf, int corner) const {
        const Sqrt3Cell cell = lattice_.cell(triangle(leaf));
        return sqrt3_site(mesh(), cell.root, cell.corner[static_cast<std::size_t>(corner)], cell.lattice());
    }

    std::uint64_t memory_bytes() const;
    /// Frees the memory reserved for the next change, except free slots: slots keep their numbers. O(leaves).
    void shrink();
    /// Whether there are free slots.
    bool has_free_slots() const { return !free_records_.empty(); }

  private:
    // Values of child_: the record of a split triangle, or one of these.
    static constexpr std::uint32_t k_whole = 0xFFFF'FFFFu, k_half = 0xFFFF'FFFEu, k_dead = 0xFFFF'FFFDu;
    static constexpr std::uint32_t k_whole_now = 0xFFFF'FFFCu, k_half_now = 0xFFFF'FFFBu;  // since the call began
    static constexpr std::uint32_t k_no_slot = 0xFFFF'FFFFu;
    // Half-edge `side` of a slot's face (also of a half triangle's) has number 3 slot + side. For the half-edge across
    // an edge there are two more values:
    static constexpr std::uint32_t k_kept = 0xFFFF'FFFFu;   // the edge is not flipped: boundary, creases, kept ones
    static constexpr std::uint32_t k_apart = 0xFFFF'FFFEu;  // the face across the edge has no slot
    static constexpr std::uint32_t k_max_slots = (k_apart - 1) / 3;

    /// A split triangle.
    struct Record {
        std::uint64_t face;
        std::uint32_t slot;
        std::uint8_t level;
    };
    static_assert(sizeof(Record) == 16);

    static std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    bool is_split(std::uint32_t slot) const { return child_[slot] < k_half_now; }
    /// The slot of the triangle over a half-edge of a split face.
    std::uint32_t child_over(std::uint32_t h) const { return first_child(child_[h / 3]) + h % 3; }
    bool is_leaf_slot(std::uint32_t slot) const { return child_[slot] == k_whole || child_[slot] == k_half; }
    std::uint32_t first_child(std::uint32_t record) const { return mesh().face_count() + 3 * record; }
    template <class Visit>
    void visit_below(std::uint32_t slot, FaceId root, Visit& visit) const {
        if (!is_split(slot)) return visit(LeafId(slot), root);
        for (std::uint32_t side = 0; side < 3; ++side) visit_below(child_over(3 * slot + side), root, visit);
    }
    std::uint32_t slot_of(int level, std::uint64_t face) const;
    bool is_split(int level, std::uint64_t face) const {
        const std::uint32_t slot = slot_of(level, face);
        return slot != k_no_slot && is_split(slot);
    }
    Sqrt3Triangle triangle_of(std::uint32_t slot) const {
        const std::uint32_t roots = mesh().face_count();
        if (slot < roots) return {0, false, slot};
        const std::uint32_t child = slot - roots;
        const Record& record = records_[child / 3];
        return {static_cast<std::uint8_t>(record.level + 1), child_[slot] == k_half, 3 * record.face + child % 3};
    }
    LeafId leaf_with(int level, std::uint64_t h) const;
    /// Slots of triangles that a split has changed, starting with its own; none if they are not all leaves.
    struct Group {
        std::vector<std::uint32_t> slots;
        std::size_t own = 0;
    };
    Group group_of(std::uint32_t record) const;
    using Twins = std::array<std::uint64_t, 3>;
    void add_needed(const Sqrt3Triangle& face, detail::PoolVector<Sqrt3Triangle>& wanted) const;
    detail::PoolVector<Sqrt3Triangle> wanted(std::span<const LeafId> marked) const;
    std::uint32_t split(const Sqrt3Triangle& face, const Twins& twins, detail::PoolVector<LeafId>& whole,
                        Changed* removed);

    /// The half-edge of a split face over which a slot's triangle stands.
    std::uint32_t over(std::uint32_t slot) const {
        const std::uint32_t child = slot - mesh().face_count();
        return 3 * records_[child / 3].slot + child % 3;
    }
    std::uint32_t beyond(int level, std::uint64_t twin) const;
    std::uint32_t across(std::uint32_t h) const;
    bool is_cut(std::uint32_t slot) const;
    std::uint32_t apex(std::uint32_t h) const;
    std::uint32_t origin(std::uint32_t h) const;
    void forget_twins();

    Sqrt3Lattice lattice_;
    std::uint32_t root_leaves_ = 0;            // faces outside holes
    detail::PoolVector<std::uint32_t> child_;  // per slot
    detail::PoolVector<Record> records_;
    std::vector<std::uint32_t> free_records_;
    struct Mutex : std::mutex {  // a copy has a mutex of its own
        Mutex() = default;
        Mutex(const Mutex&) : std::mutex() {}
        Mutex& operator=(const Mutex&) { return *this; }
    };
    mutable Mutex mutex_;
    mutable Sqrt3Lattice known_;  // stores twins; for changes, and for const calls under the mutex
};

}  // namespace tetrakis
