#include "../../hier/trees/triangle_forest.hpp"
#include "hierarchy_families.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

class TriangleFamily final : public detail::TriangleForestFamily<TriangleFamily, TriangleForest, CellTriangle> {
  public:
    TriangleFamily(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source)
        : TriangleForestFamily(
              mesh, std::move(source), TriangleForest(mesh),
              {.child_count = 4, .path_bits = 2, .max_depth = k_max_level, .root_bound = mesh.face_count()}) {}

    std::string_view name() const override { return "triangles"; }

    std::string check_site(const Site& site) const override {
        if (site.root.value >= mesh().halfedge_count() || mesh().face_halfedge(mesh().face(site.root)) != site.root)
            return "its root is not the first half-edge of a face";
        if (site.level > k_max_level) return "its lattice level is above " + std::to_string(k_max_level);
        if (std::uint64_t{site.at.x} + site.at.y > 1u << site.level)
            return "its coordinates add up to more than 2^level";
        return {};
    }
    bool has_root(std::uint32_t root) const override { return !mesh().is_hole(FaceId(root)); }

    HierarchyNode node(LeafId leaf) const override { return node_in_tree(leaf); }
    int depth(LeafId leaf) const override { return forest_.level(leaf); }
    NodeView view(const HierarchyNode& node) const override {
        const CellTriangle t = triangle(node);
        NodeView view;
        view.node = node;
        view.face = FaceId(node.root);
        view.level = node.depth;
        view.corner_count = 3;
        for (std::size_t k = 0; k < 3; ++k)
            view.corner[k] = canonical_triangle_site(mesh(), {t.root, t.corner[k], t.level});
        return view;
    }

    void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) override {
        update.removed.clear();
        forest_.refine(marked, update);
        if (with_removed) list_parents(update);
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override {
        update.removed.clear();
        forest_.coarsen(marked, update);
    }
    std::vector<LeafId> diamond(LeafId leaf) const override { return forest_.mergeable_siblings(leaf); }

    void describe(LeafId leaf, LeafView& view) const { describe_as(leaf, forest_.points(leaf), view); }
    std::uint8_t level(LeafId leaf) const { return static_cast<std::uint8_t>(forest_.level(leaf)); }
    void add_triangles(LeafId leaf, std::vector<CellTriangle>& list) const {
        const GreenTriangles green = forest_.green_triangles(leaf);
        list.insert(list.end(), green.cell.begin(), green.cell.begin() + green.count);
    }
    CellTriangle triangle(const HierarchyNode& node) const { return TriangleForest::triangle(frame(node)); }
};

}  // namespace

std::unique_ptr<HierarchyFamily> triangle_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source) {
    return std::make_unique<TriangleFamily>(mesh, std::move(source));
}

}  // namespace tetrakis
