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

    HierarchyNode node(LeafId leaf) const override { return node_in_tree(leaf); }

    void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) override {
        forest_.refine(marked, update);
        if (with_removed) list_parents(update);
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override { forest_.coarsen(marked, update); }
    std::vector<LeafId> diamond(LeafId leaf) const override { return forest_.mergeable_siblings(leaf); }

    static FaceId face(std::uint32_t root) { return FaceId(root); }
    static std::uint8_t level(std::uint8_t depth) { return depth; }
    std::array<Site, 4> corners(const HierarchyNode& node) const {
        const CellTriangle t = triangle(node);
        const auto at = [&](std::size_t k) { return canonical_triangle_site(mesh(), {t.root, t.corner[k], t.level}); };
        return {at(0), at(1), at(2)};
    }
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
