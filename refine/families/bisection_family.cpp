#include "../../hier/forest/bisection_forest.hpp"
#include "hierarchy_families.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

class BisectionFamily final : public detail::TriangleForestFamily<BisectionFamily, BisectionForest, CellTriangle> {
  public:
    BisectionFamily(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source)
        : TriangleForestFamily(mesh, std::move(source), BisectionForest(mesh),
                               {.child_count = 2,
                                .path_bits = 1,
                                .max_depth = k_max_bisection_depth,
                                .root_bound = mesh.halfedge_count()}) {}

    std::string_view name() const override { return "bisection"; }

    std::string check_site(const Site& site) const override {
        if (site.root.value >= mesh().halfedge_count())
            return "its root is half-edge " + std::to_string(site.root.value) + ", but there are " +
                   std::to_string(mesh().halfedge_count());
        if (site.level > k_max_level) return "its lattice level is above " + std::to_string(k_max_level);
        const std::uint32_t n = 1u << site.level;
        if (site.at.x > n || site.at.y > n) return "its coordinates are above 2^level";
        return {};
    }
    bool has_root(std::uint32_t root) const override { return !mesh().is_hole(mesh().face(HalfedgeId(root))); }

    HierarchyNode node(LeafId leaf) const override {
        const BisectionLeaf& l = forest_.leaf(leaf);
        return tree_.node(forest_.root(leaf).value, l.path, l.depth);
    }
    int depth(LeafId leaf) const override { return forest_.depth(leaf); }
    NodeView view(const HierarchyNode& node) const override {
        const CellTriangle t = triangle(node);
        NodeView view;
        view.node = node;
        view.face = mesh().face(t.root);
        view.level = level(node.depth);
        view.corner_count = 3;
        for (std::size_t k = 0; k < 3; ++k) view.corner[k] = corner_site(mesh(), t, k);
        return view;
    }

    void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) override {
        update.reshaped.clear();
        update.removed.clear();
        if (with_removed) list_split(marked, update);
        forest_.refine(marked, update.created);
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override {
        update.reshaped.clear();
        update.removed.clear();
        forest_.coarsen(marked, update.created);
    }
    std::vector<LeafId> diamond(LeafId leaf) const override {
        if (!forest_.can_merge(leaf)) return {};
        // Its leaves share their apex; legs lead around it.
        std::vector<LeafId> leaves{leaf};
        const auto& neighbour = forest_.leaf(leaf).neighbour;
        for (std::size_t k : {1, 2})
            if (neighbour[k].valid()) leaves.push_back(neighbour[k]);
        if (leaves.size() == 3) leaves.push_back(forest_.leaf(leaves[1]).neighbour[1]);
        return leaves;
    }

    void describe(LeafId leaf, LeafView& view) const { describe_as(leaf, forest_.leaf(leaf).vertex, view); }
    std::uint8_t level(LeafId leaf) const { return level(forest_.depth(leaf)); }
    void add_triangles(LeafId leaf, std::vector<CellTriangle>& list) const { list.push_back(forest_.triangle(leaf)); }
    CellTriangle triangle(const HierarchyNode& node) const {
        return cell_triangle(mesh(), HalfedgeId(node.root), node.depth, tree_.low_path(node));
    }

  private:
    static std::uint8_t level(int depth) { return static_cast<std::uint8_t>(lattice_level(depth) + 1); }
    // The leaves that a refinement splits: base by base from each marked one.
    void list_split(std::span<const LeafId> marked, FamilyUpdate& update) {
        seen_.resize(std::max<std::size_t>(seen_.size(), forest_.leaf_slots()), 0);
        const auto add = [&](LeafId leaf) {
            if (seen_[leaf.value]) return;
            seen_[leaf.value] = 1;
            update.removed.emplace_back(leaf, node(leaf));
        };
        for (LeafId leaf : marked) {
            add(leaf);
            for (;;) {
                const LeafId across = forest_.leaf(leaf).neighbour[0];
                if (!across.valid() || seen_[across.value]) break;
                add(across);
                if (forest_.leaf(across).neighbour[0] == leaf) break;
                leaf = across;
            }
        }
        for (const auto& [leaf, node] : update.removed) seen_[leaf.value] = 0;
    }

    std::vector<std::uint8_t> seen_;  // per slot; zero between calls
};

}  // namespace

std::unique_ptr<HierarchyFamily> bisection_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source) {
    return std::make_unique<BisectionFamily>(mesh, std::move(source));
}

}  // namespace tetrakis
