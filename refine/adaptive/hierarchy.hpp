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

/// Answers for leaves, in large batches, from the calling thread: sets wanted[i] to 1 where leaves[i] is to be refined
/// (or may be merged). The answer must depend on the leaf alone.
using LeafPredicate = std::function<void(std::span<const LeafView> leaves, std::span<std::uint8_t> wanted)>;

/// A LeafPredicate from a function of one leaf.
template <class Test>
LeafPredicate each_leaf(Test test) {
    return [test](std::span<const LeafView> leaves, std::span<std::uint8_t> wanted) {
        for (std::size_t i = 0; i < leaves.size(); ++i) wanted[i] = test(leaves[i]) ? 1 : 0;
    };
}

/// Where the vertices of Hierarchy::to_mesh() are.
enum class MeshPositions {
    limit,   ///< on the limit surface
    level,   ///< at one level of the scheme, vertices that are finer than it at the first level that has them
    finest,  ///< each at the level of the finest leaf around it: what classical adaptive subdivision shows
};

struct ToMeshOptions {
    MeshPositions positions = MeshPositions::limit;
    int level = 0;         ///< for MeshPositions::level; family "vertices": no deeper than any leaf (unsupported)
    bool normals = false;  ///< of the limit, or of the vertices' levels
    /// Cut the faces of family "vertices": quads in the 4-8 pattern, others into fans. Those of other families are
    /// triangles anyway.
    bool triangles = false;
    RunContext context{};
};

/// Adaptive refinement by hand: the leaves of a hierarchy over a control mesh, refined and coarsened one by one or by a
/// predicate or estimator, always conforming and restricted (neighbours differ by one level at most), with the points
/// that the scheme gives their vertices. Any set of leaves can be reached by refining and by coarsening, and then
/// gives the same mesh. make_hierarchy() makes one.
///
/// Levels are steps of the scheme as in refine(). Families (what roots, children and sites are):
/// * "bisection" (Catmull-Clark, Kobbelt, bilinear, 4-8, averaging with an even number of steps): roots are the
///   half-edges v -> w of faces that are no holes, as triangles (v, w, face centre); a split is the bisection of a
///   triangle's base edge, together with the neighbour across it (a diamond). Two bisections are one quad split. Sites:
///   corner cells (site.hpp);
/// * "triangles" (Loop, tuned Loop, Butterfly, Modified Butterfly, midpoint; triangles only): roots are the faces, a
///   split makes four triangles; hanging midpoints are closed in the mesh by two to four (green) triangles. Sites:
///   face triangles;
/// * "vertices" (Doo-Sabin, midedge, biquartic, averaging with an odd number of steps): nodes are vertices, which have
///   four children; the mesh has the leaves as vertices and a face where they meet. Sites: cells (cell_site()); each is
///   a vertex of its own level only. A vertex on a crease has a leaf on each side, split and merged together: one
///   diamond. Not over vertices inside where only two faces meet. See VertexForest;
/// * "sqrt3" (triangles): roots are the faces that are no holes. A split puts three half triangles in a triangle's
///   place, from its edges to its centre; where the triangle beyond an edge is split, too, both half ones become whole,
///   over the flipped edge. So a triangle's children are halves, and a half's only child is the whole one: two depths
///   are one level, a simple step, two of which are one level of refine(). Splitting a half triangle is to split the
///   triangle beyond its edge. Over sharp edges and the edges of holes, which are not flipped but cut in three by every
///   second step, triangles are whole at once; where a crease is cut, both of its triangles are split. A diamond is a
///   split's three triangles (of both sides of a crease that was cut: six); merging it turns the whole ones beyond
///   into halves again. A whole triangle beside two splits stands for its parent's diamond; where that cannot be
///   merged, coarsen(leaf) takes the one beyond. Sites: face triangles with 3^level segments a side (sqrt3_site()); two
///   levels of simple steps are one of sites. See Sqrt3Forest.
///
/// All errors leave the hierarchy unchanged. Where the system itself runs out of memory during a change
/// (std::bad_alloc), the leaves are lost: all later calls throw Error(memory_limit) until load(). Const calls are safe
/// from several threads while none changes.
class Hierarchy {
  public:
    /// The leaves of a family; its mesh and scheme outlive the hierarchy.
    /// @param rules  what its points are made by, for save() and load()
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
    /// path ("sqrt3", where siblings share a vertex, but no edge: by the control face that they lie in, then along a
    /// Z-order curve there). Cutting this range into equal parts cuts the mesh into compact ones. Valid until the next
    /// change. O(leaves log leaves) after a change.
    std::span<const LeafHandle> leaves() const;
    bool is_leaf(LeafHandle leaf) const;
    HierarchyNode node(LeafHandle leaf) const;
    LeafView view(LeafHandle leaf) const;
    /// Of any node, whether it is a leaf now or not.
    NodeView view(const HierarchyNode& node) const;
    /// The node's leaf, if it is one now. O(log leaves), after a change as leaves().
    std::optional<LeafHandle> find(const HierarchyNode& node) const;
    /// None for a root.
    std::optional<HierarchyNode> parent(const HierarchyNode& node) const;
    /// None at the largest depth.
    std::vector<HierarchyNode> children(const HierarchyNode& node) const;
    /// The leaves across side k of a leaf. O(1) (sqrt3: O(level)).
    LeafNeighbours neighbours(LeafHandle leaf, int side) const;
    /// Vertices are numbered below this (LeafView::point).
    std::uint32_t point_slots() const;

    // Changes. Each returns the leaves that are new, those of one call in an order that depends on the calls so far
    // alone. @throws Error: invalid_input: a handle is stale or was never one; memory_limit.

    /// Splits a leaf, and what has to be split with it. @throws Error  unsupported: the leaf is at the largest depth
    std::vector<LeafHandle> refine(LeafHandle leaf) { return refine({&leaf, 1}); }
    /// Splits all these leaves; repetitions do no harm. O(new leaves), parallel.
    std::vector<LeafHandle> refine(std::span<const LeafHandle> leaves);
    /// Merges the diamond (the group of leaves that a split made) that the leaf is one of: the inverse of refine().
    /// @throws Error  invalid_input: the leaf is a root, or another leaf of its diamond is split further, or a
    ///                neighbour would become too fine for it
    std::vector<LeafHandle> coarsen(LeafHandle diamond);
    /// Merges all diamonds whose leaves are all among these, as far as they can be; other leaves are left alone.
    std::vector<LeafHandle> coarsen(std::span<const LeafHandle> leaves);
    bool can_coarsen(LeafHandle leaf) const;

    /// Refines until no leaf above the depth is wanted any more. Returns the number of new leaves. What a split takes
    /// with it may be one deeper ("sqrt3": half triangles that become whole).
    /// @throws Error  as refine(); cancelled; memory_limit, with the numbers: the hierarchy and the next round of
    ///                splits would take more than context.max_memory_bytes, or, for what a round's splits took with
    ///                them, do so after it. The rounds until then stay
    std::size_t refine_where(const LeafPredicate& wanted, int max_depth, const RunContext& context = {});
    /// Refines until no leaf above the depth has an error over the tolerance. HierarchyEstimator
    /// (eval/estimate/hierarchy_estimator.hpp) measures leaves of every family against the limit surface.
    /// @throws Error  as above; invalid_input: a tolerance below zero or no number, an estimator of another hierarchy;
    ///                unsupported: the estimator is not for this family. What was refined until then stays
    std::size_t refine_where(const ErrorEstimator& estimator, double tolerance, int max_depth,
                             const RunContext& context = {});
    /// Coarsens until no diamond of leaves that are all wanted can be merged. Returns the number of new leaves.
    std::size_t coarsen_where(const LeafPredicate& wanted, const RunContext& context = {});
    /// Coarsens until every diamond that is left would have an error over the tolerance in a merged leaf. Then splits
    /// leaves again whose errors new neighbours have brought over the tolerance; leaves that were over it from the
    /// start are not split. Returns the number of new leaves before these splits.
    std::size_t coarsen_where(const ErrorEstimator& estimator, double tolerance, const RunContext& context = {});

    // Points of the scheme. Any site of the family will do, whether it is a vertex now or not. @throws Error
    // invalid_input: it is no site, or the level has no such vertex; the spans differ in length; unsupported: the
    // scheme has no limit mask for a vertex. Cost: a microsecond or two per site and level for Catmull-Clark and Loop,
    // a few microseconds per vertex of its neighbourhood and level for schemes by rules, less for many sites side by
    // side. With semi-sharp creases of Chaikin's method whole levels are made: seconds at level 10 of a cube.

    /// The first level that has the site as a vertex.
    int first_level(const Site& site) const;
    /// Where uniform refinement to that level has the vertex.
    Vec3d position(const Site& site, int level) const;
    /// The surface's limit point at the site with its tangents and normal.
    LimitPoint limit(const Site& site) const;
    /// A level's mesh about a vertex: position, normal of the faces around (by area), two directions that span the
    /// plane across it.
    LimitPoint frame(const Site& site, int level) const;
    std::array<Vec3d, 2> tangents(const Site& site) const;
    std::array<Vec3d, 2> tangents(const Site& site, int level) const;
    Vec3d normal(const Site& site) const { return limit(site).normal; }
    Vec3d normal(const Site& site, int level) const { return frame(site, level).normal; }
    void positions(std::span<const Site> sites, int level, std::span<Vec3d> out) const;
    void frames(std::span<const Site> sites, int level, std::span<LimitPoint> out) const;
    void limit_positions(std::span<const Site> sites, std::span<Vec3d> out) const;
    void limits(std::span<const Site> sites, std::span<LimitPoint> out) const;
    void normals(std::span<const Site> sites, std::span<Vec3d> out) const;  ///< those of limits()

    /// The leaves as an indexed mesh.
    /// @throws Error  invalid_input: a level out of range; unsupported: no limit mask for a vertex; cancelled;
    ///                memory_limit: the mesh would take more than context.max_memory_bytes, beside the hierarchy
    HierarchyMesh to_mesh(const ToMeshOptions& options = {}) const;

    // Journal.

    /// A mark in time for changes_since(). The first call starts the journal; without it changes cost nothing extra.
    std::uint64_t stamp();
    /// What has changed since then, in the order of the leaves' nodes. O(leaves changed since then, log of it);
    /// O(leaves) where the mesh has holes.
    /// @throws Error  invalid_input: a stamp that was never given
    HierarchyChanges changes_since(std::uint64_t stamp) const;
    /// Forgets what is older than a stamp, which changes_since() then cannot answer any more.
    void forget_before(std::uint64_t stamp);
    /// The journal keeps this many leaves of changes at most; the oldest are forgotten first.
    void limit_journal(std::size_t entries);

    // Files: the leaves, two bits or less each (sqrt3: three), with checksum; the control mesh's faces, holes, creases
    // and corners are only named by their own, the scheme and its rules by name. So leaves can be carried over to a
    // control mesh whose points have moved.

    std::vector<std::byte> saved() const;
    /// @throws Error  io
    void save(const std::filesystem::path& path) const;
    /// Replaces the leaves by saved ones; all handles are stale then, and the journal starts anew.
    /// @throws Error  invalid_input: no such file format or version, cut off, a wrong checksum, of other faces,
    ///                holes, creases, corners, scheme, family or RuleOptions, or no conforming set of leaves; io (the
    ///                path cannot be read)
    void load(std::span<const std::byte> bytes);
    void load(const std::filesystem::path& path);

    /// Verifies all invariants of the structure. Returns the first violation, or nothing. O(leaves log leaves).
    std::optional<std::string> check() const;
    /// Bytes allocated for the structure, journal included.
    std::uint64_t memory_bytes() const;
    /// Gives back the memory that the next change would use again, and the list of leaves() until it is asked for.
    /// Where leaves or points have gone and others remain beyond their places, these are closed up: returns true then,
    /// all handles are stale and points have other numbers, and the journal starts anew, as after load().
    /// What is left is what a new hierarchy refined to the same leaves takes: at most 52 bytes a leaf (bisection;
    /// triangles 31, vertices 26, sqrt3 39) and 16 for each of the first two families' vertices, for evenly refined
    /// leaves. O(leaves), to close up O(leaves log leaves) and the memory that is left a second time.
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
    std::uint32_t first_generation_ = 0;            // of slots to come
    bool lost_ = false;                             // a change has run out of memory on its way
    HierarchyJournal journal_;
    std::unique_ptr<Cache> cache_ = std::make_unique<Cache>();
};

struct HierarchyOptions {
    RuleOptions rules{};
    /// Limit positions from elsewhere, by canonical sites (such as a patch tree over the same mesh); else from the
    /// scheme's rules.
    std::shared_ptr<const PositionSource> limit_positions{};
    /// Makes whole levels where many points are asked for: faster. Their last bits then depend on what has been asked
    /// for before.
    bool whole_levels = false;
    RunContext context{};
};

/// A hierarchy of the scheme's family over a control mesh, with its roots as leaves. Keeps a reference to the mesh.
/// @throws Error  invalid_input: a mesh that the scheme cannot take, an unknown scheme name (the message has the
///                nearest one); unsupported: a scheme without hierarchy, or a choice of rules that it has none for
Hierarchy make_hierarchy(const ControlMesh& mesh, const SchemeInfo& scheme, const HierarchyOptions& options = {});
Hierarchy make_hierarchy(const ControlMesh& mesh, std::string_view scheme, const HierarchyOptions& options = {});
// A temporary mesh would be gone before the hierarchy is used.
Hierarchy make_hierarchy(const ControlMesh&&, const SchemeInfo&, const HierarchyOptions& = {}) = delete;
Hierarchy make_hierarchy(const ControlMesh&&, std::string_view, const HierarchyOptions& = {}) = delete;

}  // namespace tetrakis
