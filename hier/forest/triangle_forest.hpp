#pragma once

#include "../base/memory.hpp"
#include "../mesh/control_mesh.hpp"
#include "exported_triangles.hpp"
#include "site.hpp"
#include "triangle_cell.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrakis {

namespace detail {}

/// The triangles that stand for one leaf in the output: the leaf itself where no edge has a hanging midpoint, else its
/// conforming (green) subdivision; with three hanging midpoints, those that its split would make.
struct GreenTriangles {
    int count = 0;  ///< 1 to 4
    std::array<CellTriangle, 4> cell;
    std::array<std::array<PointId, 3>, 4> point;  ///< the corners of each
};

/// Restricted triangle quadtrees over a triangle mesh, with conforming (red-green) closure; one root per face.
///
/// A red triangle is split at its edge midpoints into four: child k < 3 keeps corner k, child 3 is the middle one,
/// whose corner k lies opposite corner k; so edge k (from corner k to corner k + 1) of every triangle of a root is
/// parallel to side k of the root. Between calls leaves that share an edge differ by at most one level. A leaf beside
/// split neighbours has hanging midpoints and is output as two or three green triangles; with three of them, as the
/// four triangles that its split would make: splitting it would change nothing but what can be refined next. So any
/// four siblings can be merged that have no leaf two levels finer beside their parent. Faces that are holes have no
/// leaves; edges towards them act as boundary.
///
/// Storage: a record of 56 bytes per split triangle, which is a third of the leaves, plus 5 bytes per triangle: 25
/// bytes a leaf, and a site of 16 per point.
/// Slots: the root of face f is slot f, the children of the k-th record are F + 4 k to F + 4 k + 3. Slots and points
/// are reused after a merge; handles of leaves and points that are gone are recognised until then.
class TriangleForest {
  public:
    /// One leaf per face that is no hole. Keeps a reference to the mesh. O(H).
    /// @throws Error  unsupported: a face is not a triangle (triangulate() makes such a mesh)
    explicit TriangleForest(const ControlMesh& mesh);
    explicit TriangleForest(const ControlMesh&&) = delete;

    const ControlMesh& mesh() const { return *mesh_; }

    /// Leaves are numbered below this; not all of these numbers are leaves.
    std::uint32_t leaf_slots() const { return static_cast<std::uint32_t>(child_.size()); }
    bool is_leaf(LeafId leaf) const { return leaf.value < child_.size() && child_[leaf.value] == k_unsplit; }
    std::uint32_t leaf_count() const { return leaf_count_; }
    int level(LeafId leaf) const;
    FaceId face(LeafId leaf) const;
    CellTriangle triangle(LeafId leaf) const;
    std::array<PointId, 3> points(LeafId leaf) const;
    /// The midpoints that hang on edges 0, 1, 2 of a leaf; invalid where none does.
    std::array<PointId, 3> hanging_points(LeafId leaf) const;
    /// The children taken from the root, two bits each, the first in the most significant of 2 level(leaf) bits.
    /// O(level).
    std::uint64_t path(LeafId leaf) const;
    /// The split triangle whose child this leaf is; invalid for a root. Its slot is no leaf's now.
    LeafId parent(LeafId leaf) const {
        return leaf.value < root_count_ ? LeafId{} : LeafId(records_[(leaf.value - root_count_) / 4].parent);
    }
    /// The four children of the parent of a leaf that is no root, leaves or not, child 0 first.
    std::array<LeafId, 4> siblings(LeafId leaf) const {
        const std::uint32_t first = first_child((leaf.value - root_count_) / 4);
        return {LeafId(first), LeafId(first + 1), LeafId(first + 2), LeafId(first + 3)};
    }
    /// The leaves across an edge: none at the boundary and towards holes, two where they are finer (in the order along
    /// the edge from corner `edge` on), else one.
    std::array<LeafId, 2> neighbours(LeafId leaf, std::uint32_t edge) const;
    /// With hanging points, at the lattice level after the leaf's.
    GreenTriangles green_triangles(LeafId leaf) const;

    /// Points are numbered below this; the control vertices come first, by their numbers.
    std::uint32_t point_slots() const { return static_cast<std::uint32_t>(sites_.size()); }
    bool is_point(PointId point) const { return point.value < sites_.size() && sites_[point.value].root.valid(); }
    std::uint32_t point_count() const { return point_count_; }
    /// The canonical site of a point; the root is invalid where there is none.
    const Site& point_site(PointId point) const { return sites_[point.value]; }

    /// Splits the marked leaves and whatever the rule of levels makes necessary, each once: the smallest such
    /// refinement.
    /// @param marked   leaves in any order; repetitions do no harm
    /// @param created  receives the new leaves, four for each split one, siblings together
    /// @param changed  receives the older leaves that remain and now have more hanging midpoints than before
    /// @throws Error   invalid_input: a handle is no leaf; unsupported: a marked leaf is at level k_max_level;
    ///                 memory_limit: more than 2^32 triangles. The forest is then unchanged.
    /// Cost: O(triangles split), about 50 ns per created leaf on one thread (large batches); parallel. The result
    /// (slots and points included) depends on the set of marked leaves and the calls before, on nothing else.
    void refine(std::span<const LeafId> marked, std::vector<LeafId>& created, std::vector<LeafId>& changed);
    /// refine() of one leaf. Returns how many triangles were split.
    std::uint32_t split(LeafId leaf);

    /// Whether the four siblings of this leaf are leaves whose merge leaves the rule of levels true.
    bool can_merge(LeafId leaf) const;
    /// Replaces the leaf and its three siblings by their parent, and frees midpoints that nobody uses any more: the
    /// exact inverse of a split. Returns the parent.
    /// @throws Error  invalid_input: not a leaf, or can_merge() is false. The forest is then unchanged.
    LeafId merge(LeafId leaf);
    /// Merges as many of the groups of four siblings that are marked completely as the rule of levels allows, all at
    /// once (of two merges one may need the other).
    /// @param created  receives the parents
    /// @param changed  receives the older leaves that remain and now have fewer hanging midpoints than before
    /// @throws Error   invalid_input: a handle is no leaf. The forest is then unchanged.
    void coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created, std::vector<LeafId>& changed);

    /// All leaves by root, then by path, child 0 first. O(leaves), parallel.
    std::vector<LeafId> ordered_leaves() const;
    /// The output mesh. O(leaves), parallel but for the numbering.
    ExportedTriangles exported() const;
    detail::PooledTriangles pooled() const;  ///< the same

    /// Verifies links, points, counts and the rule of levels. Returns the first violation, or nothing.
    std::optional<std::string> check() const;

    /// Bytes allocated.
    std::uint64_t memory_bytes() const;
    /// Gives back the memory that the next change would use again, but for that of free slots and points: what remains
    /// keeps its numbers. O(leaves).
    void shrink();
    /// Whether there are any.
    bool has_free_slots() const { return !free_records_.empty() || !free_points_.empty(); }

  private:
    // Values of child_ besides record numbers.
    static constexpr std::uint32_t k_unsplit = 0xFFFF'FFFFu;  // a leaf
    static constexpr std::uint32_t k_dead = 0xFFFF'FFFEu;     // a hole, or a child of a record that is not in use
    // Values of slots and links besides numbers.
    static constexpr std::uint32_t k_coarser = 0xFFFF'FFFFu;   // there is no triangle, or record, of this level
    static constexpr std::uint32_t k_boundary = 0xFFFF'FFFEu;  // the surface ends
    // Largest number of slots: record numbers share their 32 bits with an edge number in links.
    static constexpr std::uint64_t k_max_slots = 0xFFFF'FFF0u;

    // The corner or edge after, or before, another of the same triangle.
    static constexpr std::array<std::uint32_t, 3> k_next = {1, 2, 0}, k_previous = {2, 0, 1};

    // A split triangle.
    struct Record {
        std::array<std::uint32_t, 6> point;  // corners 0, 1, 2, then the midpoints of edges 0, 1, 2
        std::array<std::uint32_t, 3> link;   // across edge e: 4 * record + its edge; k_coarser, k_boundary
        std::uint32_t parent;                // the slot of the triangle
        std::uint32_t face;
        LatticePoint at;           // corner 0, at the triangle's level
        std::uint8_t level;        // of the triangle, not of its children
        std::uint8_t is_reversed;  // corners 1, 2 lie at -x, -y from corner 0
    };
    static_assert(sizeof(Record) == 56);

    struct Neighbour {
        std::uint32_t slot;  // of the triangle of the same level across an edge; or k_coarser, k_boundary
        std::uint32_t edge;  // that edge, seen from there
    };
    struct Frame {
        std::uint32_t face;
        LatticePoint at;
        std::uint8_t level, is_reversed;
    };
    struct PlannedSplit;
    struct LeafRun;

    bool is_split(std::uint32_t slot) const { return child_[slot] < k_dead; }
    std::uint32_t first_child(std::uint32_t record) const { return root_count_ + 4 * record; }
    Neighbour neighbour(std::uint32_t slot, std::uint32_t edge) const;
    Frame frame(std::uint32_t slot) const;
    std::array<std::uint32_t, 3> corners(std::uint32_t slot) const;
    std::uint32_t hanging_point(std::uint32_t slot, std::uint32_t edge) const;
    Site midpoint_site(const Frame& frame, std::uint32_t edge) const;

    void require_leaves(std::span<const LeafId> leaves) const;
    void mark_closure(std::span<const LeafId> marked, detail::PoolVector<std::uint32_t>& splits);
    bool mark(std::uint32_t slot);
    void close_around(std::uint32_t slot, detail::PoolVector<std::uint32_t>& found);
    PlannedSplit plan(std::uint32_t slot) const;
    void write_record(std::uint32_t record, std::uint32_t slot, const PlannedSplit& planned,
                      std::uint32_t first_free_point);
    void link_record(std::uint32_t record, const PlannedSplit& planned);
    std::uint32_t mergeable_record(LeafId leaf) const;
    bool must_stay(std::uint32_t record) const;
    void keep_what_must_stay(std::span<const std::uint32_t> records);
    void remove_records(std::span<const std::uint32_t> going);
    std::uint32_t hanging_mask(std::uint32_t slot) const;
    std::array<std::uint8_t, 4> child_masks(std::uint32_t record) const;
    std::vector<LeafRun> leaf_runs() const;
    void append_leaves(std::uint32_t record, LeafRun& run) const;
    template <class Exported>
    void write_run(const LeafRun& run, Exported& out) const;
    template <class Exported>
    void export_to(Exported& out) const;
    std::optional<std::string> check_record(std::uint32_t record) const;
    std::optional<std::string> check_points() const;

    const ControlMesh* mesh_;
    TriangleSites canonical_;
    std::uint32_t root_count_ = 0;
    std::uint32_t leaf_count_ = 0;
    std::uint32_t point_count_ = 0;
    std::vector<std::uint32_t> root_link_;     // 3 per face: 4 * face + edge across it, or k_boundary
    detail::PoolVector<std::uint32_t> child_;  // per slot: its record, or k_unsplit, k_dead
    detail::PoolVector<Record> records_;
    detail::PoolVector<Site> sites_;  // per point, canonical; no root: not in use
    std::vector<std::uint32_t> free_records_, free_points_;
    detail::PoolVector<std::uint8_t> marks_;  // per slot: will be split, or (being split) merged; zero between calls
};

// Inline: refinement and output spend most of their time here.

inline TriangleForest::Neighbour TriangleForest::neighbour(std::uint32_t slot, std::uint32_t edge) const {
    if (slot < root_count_) {
        const std::uint32_t link = root_link_[3 * std::size_t{slot} + edge];
        return link == k_boundary ? Neighbour{k_boundary, 0} : Neighbour{link / 4, link % 4};
    }
    const std::uint32_t record = (slot - root_count_) / 4, child = (slot - root_count_) % 4;
    // The middle child's edge e is the inner edge of the child at the corner that e does not touch.
    if (child == 3) return {first_child(record) + k_previous[edge], edge};
    if (edge == k_next[child]) return {first_child(record) + 3, edge};
    const std::uint32_t link = records_[record].link[edge];
    if (link >= k_boundary) return {link, 0};
    // Edge e's first half belongs to child e, its second half to child e + 1; seen from the other side they are
    // swapped.
    const std::uint32_t other = link % 4;
    return {first_child(link / 4) + (edge == child ? k_next[other] : other), other};
}

inline TriangleForest::Frame TriangleForest::frame(std::uint32_t slot) const {
    if (slot < root_count_) return {slot, {0, 0}, 0, 0};
    const Record& record = records_[(slot - root_count_) / 4];
    const std::uint32_t child = (slot - root_count_) % 4;
    const std::uint32_t step = record.is_reversed ? ~std::uint32_t{0} : 1;
    LatticePoint at{2 * record.at.x, 2 * record.at.y};
    if (child == 1 || child == 3) at.x += step;
    if (child == 2 || child == 3) at.y += step;
    return {record.face, at, static_cast<std::uint8_t>(record.level + 1),
            static_cast<std::uint8_t>(child == 3 ? !record.is_reversed : record.is_reversed)};
}

inline std::array<std::uint32_t, 3> TriangleForest::corners(std::uint32_t slot) const {
    if (slot < root_count_) {
        const HalfedgeId h(3 * slot);
        return {mesh_->origin(h).value, mesh_->origin(HalfedgeId(h.value + 1)).value,
                mesh_->origin(HalfedgeId(h.value + 2)).value};
    }
    const auto& p = records_[(slot - root_count_) / 4].point;
    switch ((slot - root_count_) % 4) {
        case 0:
            return {p[0], p[3], p[5]};
        case 1:
            return {p[3], p[1], p[4]};
        case 2:
            return {p[5], p[4], p[2]};
        default:
            return {p[4], p[5], p[3]};
    }
}

}  // namespace tetrakis
