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

/// The leaves that a bulk change created, reshaped and removed. A slot that held another leaf before counts as new.
struct FamilyUpdate : ForestChange {
    /// Receives (appended), if the caller asks for it, the leaves that are gone with their nodes, some repeatedly.
    std::vector<std::pair<LeafId, HierarchyNode>> removed;
};

/// The leaves of one kind of hierarchy over a control mesh, and the scheme's points over them; class Hierarchy is built
/// on it. A family knows slots; Hierarchy adds generations, journal and files, and checks its callers' arguments. So a
/// family's functions may rely on valid arguments unless they say otherwise.
///
/// A call that changes the family is all or nothing: if it throws, the family is as before. Const calls are safe from
/// several threads while no thread changes it.
class HierarchyFamily {
  public:
    virtual ~HierarchyFamily() = default;

    /// The family's name: "bisection", "triangles", "vertices" or "sqrt3".
    virtual std::string_view name() const = 0;
    const ControlMesh& mesh() const { return mesh_; }
    const LevelSource& source() const { return *source_; }
    const HierarchyTree& tree() const { return tree_; }
    /// A new family of the same kind, with its roots as leaves.
    virtual std::unique_ptr<HierarchyFamily> fresh() const = 0;

    /// Why a site does not belong to the family; empty if it does.
    virtual std::string check_site(const Site& site) const = 0;
    virtual bool has_root(std::uint32_t root) const = 0;

    /// Leaves are numbered below this; some of these numbers are free.
    virtual std::uint32_t leaf_slots() const = 0;
    virtual std::uint32_t leaf_count() const = 0;
    virtual bool is_leaf(LeafId slot) const = 0;
    virtual std::uint32_t point_slots() const = 0;
    virtual HierarchyNode node(LeafId leaf) const = 0;
    /// All data of a leaf but its handle's generation.
    virtual LeafView view(LeafId leaf) const = 0;
    virtual NodeView view(const HierarchyNode& node) const = 0;
    /// view() for many leaves.
    /// @param views  views of this family's leaves from before, or new ones
    virtual void views(std::span<const LeafId> leaves, std::span<LeafView> views) const = 0;
    /// The leaves across a side: none, one (the other is invalid), or two in order along the side.
    virtual std::array<LeafId, 2> neighbours(LeafId leaf, int side) const = 0;
    /// All leaves in the order of their nodes.
    virtual std::vector<LeafId> ordered_leaves() const = 0;
    /// All leaves in an order that depends on their set alone, and whose equal parts are compact regions.
    virtual std::vector<LeafId> leaves_on_curve() const { return ordered_leaves(); }
    /// The node's leaf, or an invalid id if the node is no leaf. A family returns nothing if it can only search a list
    /// of all leaves; then its leaves_on_curve() must be in the order of nodes.
    virtual std::optional<LeafId> find(const HierarchyNode& /*node*/) const { return std::nullopt; }

    /// Splits the marked leaves, and all leaves that must be split with them.
    /// @param marked        leaves above the largest depth; repetitions are allowed
    /// @param with_removed  whether to fill update.removed
    virtual void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) = 0;
    /// Merges each group of leaves (diamond) that may be merged if all of its leaves are marked. Fills update.removed
    /// with the unmarked leaves that are gone or in `created`; all others that are gone are in `marked`.
    virtual void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) = 0;
    /// The leaves that would vanish if this one were merged; empty if it cannot be merged.
    virtual std::vector<LeafId> diamond(LeafId leaf) const = 0;

    /// For each leaf, the estimator's largest error over its output triangles.
    virtual void leaf_errors(std::span<const LeafId> leaves, const ErrorEstimator& estimator,
                             std::span<double> errors) const = 0;
    /// The same for nodes whose children are merged: leaves among leaves of equal size. sqrt3: for a half triangle, the
    /// larger error of the whole triangle above it and the half one across its edge.
    virtual void node_errors(std::span<const HierarchyNode> nodes, const ErrorEstimator& estimator,
                             std::span<double> errors) const = 0;

    /// The leaves as a mesh without positions; the handles have no generations.
    /// @param diagonal_at_first  receives DualFaces::diagonal_at_first; empty if all faces are triangles
    virtual HierarchyMesh faces(std::vector<std::uint8_t>& diagonal_at_first) const = 0;
    /// The first violation of the structure's invariants, or nothing.
    virtual std::optional<std::string> check() const = 0;
    virtual std::uint64_t memory_bytes() const = 0;
    /// Frees the memory that is reserved for the next change, except free slots.
    virtual void shrink() = 0;
    /// Whether there are unused slots or points, which a new family with the same leaves would not have.
    virtual bool has_free_slots() const = 0;

  protected:
    HierarchyFamily(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source, const HierarchyTree& tree)
        : mesh_(mesh), source_(std::move(source)), tree_(tree) {}

    const ControlMesh& mesh_;
    std::shared_ptr<const LevelSource> source_;
    HierarchyTree tree_;
};

}  // namespace tetrakis
