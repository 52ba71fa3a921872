#include "../kit/hierarchy_helpers.hpp"

#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/adaptive/hierarchy_families.hpp"
#include "../../refine/adaptive/level_source.hpp"
#include "../../refine/adaptive/partial_levels.hpp"
#include "../../refine/adaptive/sqrt3_sites.hpp"
#include "../../refine/adaptive/vertex_levels.hpp"

#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <utility>

using namespace tetrakis;

namespace {

/// A sound family that can be made to lie.
class Liar final : public HierarchyFamily {
  public:
    enum class Lie { none, fault, count, order, missing, twice, node, inside, corner, neighbour };
    std::shared_ptr<Lie> lie = std::make_shared<Lie>(Lie::none);

    explicit Liar(std::unique_ptr<HierarchyFamily> family) : truth_(std::move(family)) {}

    std::string_view name() const override { return truth_->name(); }
    const ControlMesh& mesh() const override { return truth_->mesh(); }
    const LevelSource& source() const override { return truth_->source(); }
    const HierarchyTree& tree() const override { return truth_->tree(); }
    std::unique_ptr<HierarchyFamily> fresh() const override { return truth_->fresh(); }
    std::string check_site(const Site& site) const override { return truth_->check_site(site); }
    bool has_root(std::uint32_t root) const override { return truth_->has_root(root); }
    std::uint32_t leaf_slots() const override { return truth_->leaf_slots(); }
    std::uint32_t leaf_count() const override { return truth_->leaf_count() + (*lie == Lie::count ? 1 : 0); }
    bool is_leaf(LeafId slot) const override { return truth_->is_leaf(slot); }
    std::uint32_t point_slots() const override { return truth_->point_slots(); }
    HierarchyNode node(LeafId leaf) const override {
        HierarchyNode node = truth_->node(leaf);
        if (leaf != last()) return node;
        if (*lie == Lie::node) node.path |= 1;
        if (*lie == Lie::inside) node = tree().child(truth_->node(truth_->ordered_leaves().end()[-2]), 0);
        return node;
    }
    LeafView view(LeafId leaf) const override {
        LeafView view = truth_->view(leaf);
        if (*lie == Lie::corner && leaf == last()) std::swap(view.corner[0], view.corner[1]);
        return view;
    }
    NodeView view(const HierarchyNode& node) const override { return truth_->view(node); }
    std::array<LeafId, 2> neighbours(LeafId leaf, int side) const override {
        auto result = truth_->neighbours(leaf, side);
        if (*lie == Lie::neighbour && leaf == last()) result[0] = LeafId{};
        return result;
    }
    std::vector<LeafId> ordered_leaves() const override {
        auto leaves = truth_->ordered_leaves();
        if (*lie == Lie::order) std::swap(leaves[0], leaves[1]);
        if (*lie == Lie::missing) leaves.pop_back();
        if (*lie == Lie::twice) leaves.back() = leaves.front();
        return leaves;
    }
    void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) override {
        truth_->refine(marked, with_removed, update);
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override { truth_->coarsen(marked, update); }
    std::vector<LeafId> diamond(LeafId leaf) const override { return truth_->diamond(leaf); }
    void leaf_errors(std::span<const LeafId> leaves, const ErrorEstimator& e, std::span<double> errors) const override {
        truth_->leaf_errors(leaves, e, errors);
    }
    void node_errors(std::span<const HierarchyNode> nodes, const ErrorEstimator& e,
                     std::span<double> errors) const override {
        truth_->node_errors(nodes, e, errors);
    }
    HierarchyFaces faces(bool with_levels) const override { return truth_->faces(with_levels); }
    std::optional<std::string> check() const override {
        if (*lie == Lie::fault) return "leaf 1: a fault of the family's own";
        return truth_->check();
    }
    std::uint64_t memory_bytes() const override { return truth_->memory_bytes(); }
    void shrink() override { truth_->shrink(); }
    bool has_free_slots() const override { return truth_->has_free_slots(); }

  private:
    LeafId last() const { return truth_->ordered_leaves().back(); }
    std::unique_ptr<HierarchyFamily> truth_;
};

std::unique_ptr<HierarchyFamily> sound_family(std::string_view scheme, const ControlMesh& mesh) {
    if (scheme == "doo-sabin") {
        const auto points = std::make_shared<const PartialLevels>(mesh, *find_scheme(scheme));
        return vertex_family(mesh, vertex_levels(points), points->vertex_roots());
    }
    if (scheme == "sqrt3") return sqrt3_family(mesh, sqrt3_levels(mesh, sqrt3_tree_levels(mesh)));
    if (scheme == "midpoint") return triangle_family(mesh, linear_levels(mesh, true));
    return bisection_family(mesh, linear_levels(mesh, false));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("check() of a hierarchy finds what its family gets wrong, and names it") {
    using Lie = Liar::Lie;
    for (const std::string_view scheme : {"bilinear", "midpoint", "doo-sabin", "sqrt3"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 2);
        auto family = std::make_unique<Liar>(sound_family(scheme, mesh));
        const auto lie = family->lie;
        Hierarchy h(std::move(family), *find_scheme(scheme));
        const std::pair<Lie, const char*> faults[] = {
            {Lie::fault, "own"},           {Lie::count, "not all leaves"}, {Lie::order, "out of order"},
            {Lie::missing, "not all"},     {Lie::twice, "order"},          {Lie::node, "none of the tree"},
            {Lie::inside, "another leaf"}, {Lie::corner, "corner 0"},      {Lie::neighbour, "lead back"}};
        for (const auto& [what, text] : faults) {
            *lie = Lie::none;
            h.refine(h.leaves().front());  // forgets the leaves in order, as they were told
            REQUIRE(!h.check());
            h.refine(h.leaves().front());
            *lie = what;
            const auto fault = h.check();
            CAPTURE(static_cast<int>(what));
            REQUIRE(fault.has_value());
            INFO(*fault);
            CHECK(fault->find(text) != std::string::npos);
        }
    }
}

TEST_SUITE_END();
