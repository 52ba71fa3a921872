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

    HierarchyNode node(LeafId leaf) const override {
        const BisectionLeaf& l = forest_.leaf(leaf);
        return tree_.node(forest_.root(leaf).value, l.path, l.depth);
    }

    void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) override {
        if (with_removed) list_split(marked, update);
        forest_.refine(marked, update.created);
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override {
        forest_.coarsen(marked, update.created);
    }
    std::vector<LeafId> diamond(LeafId leaf) const override {
        if (!forest_.can_merge(leaf)) return {};
        // The leaves of a diamond share their apex; neighbours 1 and 2, across the legs, lead around it.
        std::vector<LeafId> leaves{leaf};
        const auto& neighbour = forest_.leaf(leaf).neighbour;
        for (std::size_t k : {1, 2})
            if (neighbour[k].valid()) leaves.push_back(neighbour[k]);
        if (leaves.size() == 3) leaves.push_back(forest_.leaf(leaves[1]).neighbour[1]);
        return leaves;
    }

    FaceId face(std::uint32_t root) const { return mesh().face(HalfedgeId(root)); }
    static std::uint8_t level(int depth) { return static_cast<std::uint8_t>(lattice_level(depth) + 1); }
    std::array<Site, 4> corners(const HierarchyNode& node) const {
        const CellTriangle t = triangle(node);
        return {corner_site(mesh(), t, 0), corner_site(mesh(), t, 1), corner_site(mesh(), t, 2)};
    }
    void add_triangles(LeafId leaf, std::vector<CellTriangle>& list) const { list.push_back(forest_.triangle(leaf)); }
    CellTriangle triangle(const HierarchyNode& node) const {
        return cell_triangle(mesh(), HalfedgeId(node.root), node.depth, tree_.low_path(node));
    }

  private:
    // Lists the leaves that a refinement splits: from each marked leaf, the chain of neighbours across base edges.
    void list_split(std::span<const LeafId> marked, FamilyUpdate& update) const {
        for (LeafId leaf : marked)
            for (LeafId before; leaf.valid(); before = std::exchange(leaf, forest_.leaf(leaf).neighbour[0])) {
                update.removed.emplace_back(leaf, node(leaf));
                if (forest_.leaf(leaf).neighbour[0] == before) break;
            }
    }
};

}  // namespace

std::unique_ptr<HierarchyFamily> bisection_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source) {
    return std::make_unique<BisectionFamily>(mesh, std::move(source));
}

}  // namespace tetrakis
