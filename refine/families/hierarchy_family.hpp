#pragma once

#include "../../hier/forest/exported_triangles.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../points/level_source.hpp"
#include "error_estimator.hpp"
#include "hierarchy_leaf.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis {

/// What a bulk change did to a family's leaves. A slot that held another leaf before counts as new.
struct FamilyUpdate : ForestChange {
    /// Receives (appended) leaves that are gone, with their nodes, some repeatedly; only where asked for.
    std::vector<std::pair<LeafId, HierarchyNode>> removed;
};

/// The leaves of one kind of hierarchy over a control mesh, and the scheme's points over them: what class Hierarchy is
/// made of. A family knows slots; Hierarchy adds generations, journal, files and the checks of what its callers hand
/// in, so a family's functions may rely on valid arguments unless they say otherwise.
///
/// A changing call is all or nothing: where it throws, the family is as before. Const calls are safe from several
/// threads while none changes.
class HierarchyFamily {
  public:
    virtual ~HierarchyFamily() = default;

    /// What roots, sites and children of a node are: one paragraph for users.
    virtual std::string_view name() const = 0;
    const ControlMesh& mesh() const { return mesh_; }
    const LevelSource& source() const { return *source_; }
    const HierarchyTree& tree() const { return tree_; }
    /// The same family with its roots as leaves.
    virtual std::unique_ptr<HierarchyFamily> fresh() const = 0;

    /// Why a site is none of the family's; empty if it is one.
    virtual std::string check_site(const Site& site) const = 0;
    virtual bool has_root(std::uint32_t root) const = 0;

    /// Leaves are numbered below this; not all of these numbers are leaves.
    virtual std::uint32_t leaf_slots() const = 0;
    virtual std::uint32_t leaf_count() const = 0;
    virtual bool is_leaf(LeafId slot) const = 0;
    virtual std::uint32_t point_slots() const = 0;
    virtual HierarchyNode node(LeafId leaf) const = 0;
    /// All but the handle's generation.
    virtual LeafView view(LeafId leaf) const = 0;
    virtual NodeView view(const HierarchyNode& node) const = 0;
    /// view() of many leaves.
    /// @param views  holds views of this family's leaves, or new ones
    virtual void views(std::span<const LeafId> leaves, std::span<LeafView> views) const = 0;
    /// Across a side: none, one (the other invalid), or two in the order along the side.
    virtual std::array<LeafId, 2> neighbours(LeafId leaf, int side) const = 0;
    /// In the order of their nodes.
    virtual std::vector<LeafId> ordered_leaves() const = 0;
    /// In an order whose equal parts are compact; depends on the set of leaves alone.
    virtual std::vector<LeafId> leaves_on_curve() const { return ordered_leaves(); }
    /// The node's leaf, or an invalid one if it is none, of families that find it without a list of all; those that do
    /// not have leaves_on_curve() in the order of nodes.
    virtual std::optional<LeafId> find(const HierarchyNode& /*node*/) const { return std::nullopt; }

    /// Splits the marked leaves, and what else has to be split.
    /// @param marked        leaves, none at the largest depth; repetitions do no harm
    /// @param with_removed  fill update.removed
    virtual void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) = 0;
    /// Merges all groups of leaves (diamonds) that may be merged and whose leaves are all marked. `removed`
    /// has what was not marked and is no leaf any more or `created`; the rest of it is among `marked`.
    virtual void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) = 0;
    /// The leaves that a merge of this one would take away; empty where it cannot be merged.
    virtual std::vector<LeafId> diamond(LeafId leaf) const = 0;

    /// The largest of the estimator's errors over a leaf's output triangles.
    virtual void leaf_errors(std::span<const LeafId> leaves, const ErrorEstimator& estimator,
                             std::span<double> errors) const = 0;
    /// The same for what merging their children makes of nodes: leaves among leaves of their own size (sqrt3: of a half
    /// one whose whole one is merged away, the whole parent and the half one beyond).
    virtual void node_errors(std::span<const HierarchyNode> nodes, const ErrorEstimator& estimator,
                             std::span<double> errors) const = 0;

    /// The leaves as a mesh without positions; handles without their generations.
    /// @param diagonal_at_first  receives, per face, what DualFaces says; empty where all faces are triangles
    virtual HierarchyMesh faces(std::vector<std::uint8_t>& diagonal_at_first) const = 0;
    /// The first violation of the structure's invariants, or nothing.
    virtual std::optional<std::string> check() const = 0;
    virtual std::uint64_t memory_bytes() const = 0;
    /// Gives back the memory that the next change would use again, but for that of free slots.
    virtual void shrink() = 0;
    /// Whether there are slots or points that a fresh family with the same leaves would not have.
    virtual bool has_free_slots() const = 0;

  protected:
    HierarchyFamily(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source, const HierarchyTree& tree)
        : mesh_(mesh), source_(std::move(source)), tree_(tree) {}

    const ControlMesh& mesh_;
    std::shared_ptr<const LevelSource> source_;
    HierarchyTree tree_;
};

}  // namespace tetrakis
