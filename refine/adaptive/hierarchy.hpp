#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../families/error_estimator.hpp"
#include "../families/hierarchy_leaf.hpp"
#include "../points/position_source.hpp"
#include "../rules/limit_point.hpp"
#include "hierarchy_journal.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis {

class HierarchyFamily;
struct FamilyUpdate;

/// Decides for leaves, in large batches, from the calling thread: sets wanted[i] to 1 if leaves[i] is to be refined (or
/// may be merged). The answer must depend on the leaf alone.
using LeafPredicate = std::function<void(std::span<const LeafView> leaves, std::span<std::uint8_t> wanted)>;

/// Makes a LeafPredicate from a function of one leaf.
template <class Test>
LeafPredicate each_leaf(Test test) {
    return [test](std::span<const LeafView> leaves, std::span<std::uint8_t> wanted) {
        for (std::size_t i = 0; i < leaves.size(); ++i) wanted[i] = test(leaves[i]) ? 1 : 0;
    };
}

/// Where the vertices of Hierarchy::to_mesh() are.
enum class MeshPositions {
    limit,   ///< on the limit surface
    level,   ///< at one level of the scheme; vertices that this level does not have, at their first level
    finest,  ///< each at the level of the finest leaf around it, as in classical adaptive subdivision
};

struct ToMeshOptions {
    MeshPositions positions = MeshPositions::limit;
    int level = 0;  ///< for MeshPositions::level; family "vertices": at most the coarsest leaf's, else unsupported
    bool normals = false;  ///< normals of the limit, or of the vertices' levels
    /// Cut the faces of family "vertices": quads in the 4-8 pattern, others into fans. Faces of the other families are
    /// triangles.
    bool triangles = false;
    RunContext context{};
};

/// Adaptive refinement by hand: the leaves of a hierarchy over a control mesh, and the scheme's points at their
/// vertices. Leaves are refined and coarsened one by one, or by a predicate or estimator. They always conform and are
/// restricted: neighbours differ by one level at most. Any set of leaves can be reached by refining and by coarsening,
/// and then gives the same mesh. make_hierarchy() makes a hierarchy.
///
/// Levels are steps of the scheme as in refine(). Families differ in their roots, children and sites:
/// * "bisection" (Catmull-Clark, Kobbelt, bilinear, 4-8, averaging with an even number of steps): a root is the
///   triangle (v, w, face centre) at a half-edge v -> w of a face that is no hole. A split bisects the base edge of a
///   triangle and of its neighbour across that edge (a diamond). Two bisections are one quad split. Sites: corner cells
///   (site.hpp);
/// * "triangles" (Loop, tuned Loop, Butterfly, Modified Butterfly, midpoint; triangles only): roots are the faces. A
///   split makes four triangles; in the mesh, two to four (green) triangles close hanging midpoints. Sites: face
///   triangles;
/// * "vertices" (Doo-Sabin, midedge, biquartic, averaging with an odd number of steps): nodes are vertices, with four
///   children each. The mesh has the leaves as vertices, and a face where leaves meet. Sites: cells (cell_site()); each
///   is a vertex of its own level only. A vertex on a crease has a leaf on each side; these are split and merged
///   together, as one diamond. Interior vertices where only two faces meet are not supported. See VertexForest;
/// * "sqrt3" (triangles only): roots are the faces that are no holes. A split replaces a triangle by three half
///   triangles, from its edges to its centre. If the triangle across an edge is split as well, the two halves become
///   whole triangles, across the flipped edge. So a triangle's children are halves, and a half's only child is a whole
///   one. Two depths are one level, which is a simple step; two of these are one level of refine(). Splitting a half
///   triangle splits the triangle across its edge. Sharp edges and edges of holes are not flipped: every second step
///   cuts them in three. Triangles over them are whole at once, and if a crease is cut, both of its triangles are
///   split. A diamond is the three triangles of a split (six, of both sides, if a crease was cut); its merge turns
///   whole triangles across its edges into halves. A whole triangle between two splits stands for its parent's diamond;
///   if that cannot be merged, coarsen(leaf) merges the other one. Sites: face triangles with 3^level segments a side
///   (sqrt3_site()); two levels of simple steps are one level of sites. See Sqrt3Forest.
///
/// All errors leave the hierarchy unchanged, with one exception: if the system runs out of memory during a change
/// (std::bad_alloc), the leaves are lost. Then calls that need leaves throw Error(memory_limit) until load(). Const
/// calls are safe from several threads while no thread changes the hierarchy.
class Hierarchy {
  public:
    /// Takes the leaves of a family, whose mesh must outlive the hierarchy, as must the scheme.
    /// @param rules  the options by which the family's points are computed, for save() and load()
    Hierarchy(std::unique_ptr<HierarchyFamily> family, const SchemeInfo& scheme, const RuleOptions& rules = {});
    Hierarchy(Hierarchy&&) noexcept;
    Hierarchy& operator=(Hierarchy&&) noexcept;
    ~Hierarchy();

    const ControlMesh& mesh() const;
    const SchemeInfo& scheme() const { return *scheme_; }
    /// "bisection", "triangles", ...
    std::string_view family() const;
    /// The shape of the trees: depth limit, children of a node. Valid until load() or shrink().
    const HierarchyTree& tree() const;

    // Leaves and nodes.

    std::uint32_t leaf_count() const;
    /// All leaves in the order of a space-filling curve, which depends on the set of leaves alone: by root, then by
    /// path. For "sqrt3", whose siblings share a vertex but no edge: by control face, then along a Z-order curve there.
    /// Equal parts of this range are compact parts of the mesh. Valid until the next change. O(leaves log leaves) after
    /// a change.
    std::span<const LeafHandle> leaves() const;
    bool is_leaf(LeafHandle leaf) const;
    HierarchyNode node(LeafHandle leaf) const;
    LeafView view(LeafHandle leaf) const;
    /// The same for any node, whether it is a leaf or not.
    NodeView view(const HierarchyNode& node) const;
    /// The node's leaf, if it is one now. O(log leaves); after a change, the cost of leaves().
    std::optional<LeafHandle> find(const HierarchyNode& node) const;
    /// The node's parent; nothing for a root.
    std::optional<HierarchyNode> parent(const HierarchyNode& node) const;
    /// The node's children; none at the largest depth.
    std::vector<HierarchyNode> children(const HierarchyNode& node) const;
    /// The leaves across side k of a leaf. O(1) (sqrt3: O(level)).
    LeafNeighbours neighbours(LeafHandle leaf, int side) const;
    /// Vertices are numbered below this (LeafView::point).
    std::uint32_t point_slots() const;

    // Changes. Each returns the new leaves. The order of one call's leaves depends only on the calls so far.
    // @throws Error: invalid_input: a handle is stale or was never valid; memory_limit.

    /// Splits a leaf and what must be split with it. @throws Error  unsupported: the leaf is at the largest depth
    std::vector<LeafHandle> refine(LeafHandle leaf) { return refine({&leaf, 1}); }
    /// Splits all these leaves; repetitions are allowed. O(new leaves), parallel.
    std::vector<LeafHandle> refine(std::span<const LeafHandle> leaves);
    /// Merges the leaf's diamond, which is the group of leaves that a split made: the inverse of refine().
    /// @throws Error  invalid_input: the leaf is a root, or another leaf of its diamond is split further, or a
    ///                neighbour would become too fine for it
    std::vector<LeafHandle> coarsen(LeafHandle diamond);
    /// Merges each diamond that can be merged and whose leaves are all among `leaves`. Other leaves stay as they are.
    std::vector<LeafHandle> coarsen(std::span<const LeafHandle> leaves);
    bool can_coarsen(LeafHandle leaf) const;

    /// Refines until no leaf above `max_depth` is wanted. Returns the number of new leaves. Leaves that must be split
    /// with others may end one deeper than `max_depth` ("sqrt3": half triangles that become whole).
    /// @throws Error  as refine(); cancelled; memory_limit, with the numbers: before a round, the hierarchy and the
    ///                round's splits would take more than context.max_memory_bytes; or after it, because of the leaves
    ///                that had to be split as well. Completed rounds are not undone
    std::size_t refine_where(const LeafPredicate& wanted, int max_depth, const RunContext& context = {});
    /// Refines until no leaf above `max_depth` has an error over the tolerance. HierarchyEstimator
    /// (eval/estimate/hierarchy_estimator.hpp) measures leaves of every family against the limit surface.
    /// @throws Error  as above; invalid_input: the tolerance is negative or NaN, or the estimator is for another
    ///                hierarchy; unsupported: it does not support this family. Completed rounds are not undone
    std::size_t refine_where(const ErrorEstimator& estimator, double tolerance, int max_depth,
                             const RunContext& context = {});
    /// Coarsens until no diamond whose leaves are all wanted can be merged. Returns the number of new leaves.
    std::size_t coarsen_where(const LeafPredicate& wanted, const RunContext& context = {});
    /// Coarsens until each diamond that can still be merged would have a merged leaf with an error over the tolerance.
    /// Merges change the errors of leaves beside them: those now over the tolerance are split again. Leaves that were
    /// over it at the start are not split. Returns the number of new leaves, without these splits.
    std::size_t coarsen_where(const ErrorEstimator& estimator, double tolerance, const RunContext& context = {});

    // Points of the scheme. Any site of the family is allowed, whether it is a vertex now or not. @throws Error
    // invalid_input: it is no site, or the level has no such vertex; the spans differ in length; unsupported: the
    // scheme has no limit mask for a vertex. Cost: one or two microseconds per site and level for Catmull-Clark and
    // Loop. Schemes by rules take a few microseconds per vertex of its neighbourhood and level, less for many adjacent
    // sites. Semi-sharp creases of Chaikin's method need whole levels: seconds at level 10 of a cube.

    /// The first level that has the site as a vertex.
    int first_level(const Site& site) const;
    /// The position of the vertex after uniform refinement to that level.
    Vec3d position(const Site& site, int level) const;
    /// The surface's limit point at the site with its tangents and normal.
    LimitPoint limit(const Site& site) const;
    /// The mesh of a level around a vertex: its position, the area-weighted normal of its faces, and two directions
    /// that span the plane across the normal.
    LimitPoint frame(const Site& site, int level) const;
    std::array<Vec3d, 2> tangents(const Site& site) const;
    std::array<Vec3d, 2> tangents(const Site& site, int level) const;
    Vec3d normal(const Site& site) const { return limit(site).normal; }
    Vec3d normal(const Site& site, int level) const { return frame(site, level).normal; }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const;
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const;
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const;
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const;
    void normals(std::span<const Site> sites, std::span<Vec3d> out) const;  ///< the normals of limits()

    /// The leaves as an indexed mesh.
    /// @throws Error  invalid_input: a level out of range; unsupported: no limit mask for a vertex; cancelled;
    ///                memory_limit: the mesh would take more than context.max_memory_bytes, beside the hierarchy
    HierarchyMesh to_mesh(const ToMeshOptions& options = {}) const;

    // Journal.

    /// The present stamp, for changes_since(). The first call starts the journal; before it, changes cost no extra.
    std::uint64_t stamp();
    /// The changes since then, in the order of the leaves' nodes. O(leaves changed since then, log of it); O(leaves) if
    /// the mesh has holes.
    /// @throws Error  invalid_input: stamp() never returned this
    HierarchyChanges changes_since(std::uint64_t stamp) const;
    /// Forgets the changes before a stamp. changes_since() cannot answer for older stamps any more.
    void forget_before(std::uint64_t stamp);
    /// The journal stores at most this many changed leaves; it forgets the oldest changes first.
    void limit_journal(std::size_t entries);

    // Files store the leaves (two bits or less each; sqrt3: three) and a checksum. The control mesh is not stored, only
    // a fingerprint of its faces, holes, creases and corners, and the names of scheme and rules. So leaves can be
    // loaded over a control mesh whose points have moved.

    std::vector<std::byte> saved() const;
    /// @throws Error  io
    void save(const std::filesystem::path& path) const;
    /// Replaces the leaves by saved ones. All handles become stale, and the journal starts anew.
    /// @throws Error  invalid_input: unknown file format or version; cut off; wrong checksum; other faces, holes,
    ///                creases, corners, scheme, family or RuleOptions; no conforming set of leaves; io: the path cannot
    ///                be read
    void load(std::span<const std::byte> bytes);
    void load(const std::filesystem::path& path);

    /// Verifies all invariants of the structure. Returns the first violation, or nothing. O(leaves log leaves).
    std::optional<std::string> check() const;
    /// Bytes allocated for the structure, journal included.
    std::uint64_t memory_bytes() const;
    /// Frees the memory reserved for the next change, and the list of leaves() until it is needed. If leaves or points
    /// have left free slots, all are renumbered without gaps: then it returns true, all handles are stale, points have
    /// other numbers, and the journal starts anew, as after load(). Afterwards the hierarchy takes what a new one
    /// refined to the same leaves takes. For evenly refined leaves that is at most 52 bytes a leaf (bisection;
    /// triangles 31, vertices 26, sqrt3 39), and 16 for each vertex of the first two families. O(leaves); with
    /// renumbering O(leaves log leaves), and the remaining memory is needed twice for a while.
    bool shrink();

  private:
    struct Cache {
        std::mutex mutex;
        bool valid = false;
        std::vector<LeafHandle> leaves;
    };

    LeafHandle handle(LeafId slot) const { return {slot, generation_[slot.value]}; }
    void require_not_lost() const;
    template <class Change>
    auto all_or_lost(Change&& change);
    void require_leaf(LeafHandle leaf) const;
    std::vector<LeafId> require_leaves(std::span<const LeafHandle> leaves) const;
    void require_node(const HierarchyNode& node) const;
    void require_sites(std::span<const Site> sites, std::size_t out) const;
    void require_level(std::span<const Site> sites, int level) const;
    template <class Make>
    void apply(std::span<const LeafId> marked, FamilyUpdate& update, Make&& make);
    void apply_refine(std::span<const LeafId> marked, FamilyUpdate& update);
    void apply_coarsen(std::span<const LeafId> marked, FamilyUpdate& update);
    std::unique_ptr<HierarchyFamily> rebuilt(std::span<const HierarchyNode> nodes) const;
    void replace_leaves(std::unique_ptr<HierarchyFamily> family);
    void ask(const LeafPredicate& wanted, std::span<const LeafId> leaves,
             detail::PoolVector<std::uint8_t>& answers) const;
    std::vector<LeafHandle> handles(std::span<const LeafId> slots) const;
    template <class Marks>
    std::size_t refine_until(std::vector<LeafId> open, int max_depth, const RunContext& context, Marks&& marks);
    template <class Marks>
    std::size_t coarsen_until(const RunContext& context, Marks&& marks);
    std::size_t refine_over(const ErrorEstimator& estimator, double tolerance, std::vector<LeafId> open, int max_depth,
                            const RunContext& context, std::span<const HierarchyNode> spared);
    std::vector<LeafId> leaves_around(LeafId start, PointId corner) const;
    void evaluate(HierarchyMesh& result, const ToMeshOptions& options) const;

    std::unique_ptr<HierarchyFamily> family_;
    const SchemeInfo* scheme_;
    std::string rules_;  // rule_choices()
    bool has_holes_ = false;
    detail::PoolVector<std::uint32_t> generation_;  // per slot
    std::uint32_t first_generation_ = 0;            // of slots that do not exist yet
    bool lost_ = false;                             // a change ran out of memory halfway
    HierarchyJournal journal_;
    std::unique_ptr<Cache> cache_ = std::make_unique<Cache>();
};

struct HierarchyOptions {
    RuleOptions rules{};
    /// Limit positions from another source, by canonical sites (such as a patch tree over the same mesh); if empty,
    /// from the scheme's rules.
    std::shared_ptr<const PositionSource> limit_positions{};
    /// Computes whole levels if many points are asked for, which is faster. The last bits of points then depend on the
    /// calls before.
    bool whole_levels = false;
    RunContext context{};
};

/// Makes a hierarchy of the scheme's family, with its roots as leaves. Keeps a reference to the mesh.
/// @throws Error  invalid_input: the scheme cannot take the mesh, or the name is unknown (the message has the nearest
///                one); unsupported: the scheme has no hierarchy, or none for these rules
Hierarchy make_hierarchy(const ControlMesh& mesh, const SchemeInfo& scheme, const HierarchyOptions& options = {});
Hierarchy make_hierarchy(const ControlMesh& mesh, std::string_view scheme, const HierarchyOptions& options = {});
// A temporary mesh would be destroyed before the hierarchy is used.
Hierarchy make_hierarchy(const ControlMesh&&, const SchemeInfo&, const HierarchyOptions& = {}) = delete;
Hierarchy make_hierarchy(const ControlMesh&&, std::string_view, const HierarchyOptions& = {}) = delete;

}  // namespace tetrakis
