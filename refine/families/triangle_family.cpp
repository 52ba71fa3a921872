#include "../../hier/trees/triangle_forest.hpp"
#include "hierarchy_families.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

class TriangleFamily final : public detail::ForestFamily<TriangleFamily, TriangleForest> {
  public:
    TriangleFamily(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source)
        : ForestFamily(mesh, std::move(source), TriangleForest(mesh),
                       {.child_count = 4, .path_bits = 2, .max_depth = k_max_level, .root_bound = mesh.face_count()}) {}

    std::string_view name() const override { return "triangles"; }
    std::unique_ptr<HierarchyFamily> fresh() const override { return std::make_unique<TriangleFamily>(mesh_, source_); }

    std::string check_site(const Site& site) const override {
        if (site.root.value >= mesh().halfedge_count() || mesh().face_halfedge(mesh().face(site.root)) != site.root)
            return "its root is not the first half-edge of a face";
        if (site.level > k_max_level) return "its lattice level is above " + std::to_string(k_max_level);
        if (std::uint64_t{site.at.x} + site.at.y > 1u << site.level)
            return "its coordinates add up to more than 2^level";
        return {};
    }
    bool has_root(std::uint32_t root) const override { return !mesh().is_hole(FaceId(root)); }

    HierarchyNode node(LeafId leaf) const override {
        const int level = forest_.level(leaf);
        return {forest_.face(leaf).value, level == 0 ? 0 : forest_.path(leaf) << (64 - 2 * level),
                static_cast<std::uint8_t>(level)};
    }
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
        if (!with_removed) return;
        for (std::size_t i = 0; i < update.created.size(); i += 4)
            update.removed.emplace_back(forest_.parent(update.created[i]), tree_.parent(node(update.created[i])));
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override {
        update.removed.clear();
        forest_.coarsen(marked, update);
    }
    std::vector<LeafId> diamond(LeafId leaf) const override { return forest_.mergeable_siblings(leaf); }

    void leaf_errors(std::span<const LeafId> leaves, const ErrorEstimator& estimator,
                     std::span<double> errors) const override {
        detail::largest_errors<CellTriangle>(leaves, estimator, errors, [&](LeafId leaf, auto& list) {
            const GreenTriangles green = forest_.green_triangles(leaf);
            list.insert(list.end(), green.cell.begin(), green.cell.begin() + green.count);
        });
    }
    void node_errors(std::span<const HierarchyNode> nodes, const ErrorEstimator& estimator,
                     std::span<double> errors) const override {
        detail::largest_errors<CellTriangle>(
            nodes, estimator, errors, [&](const HierarchyNode& node, auto& list) { list.push_back(triangle(node)); });
    }

    HierarchyFaces faces(bool with_levels) const override {
        return detail::faces_of(forest_.exported(), with_levels,
                                [&](LeafId leaf) { return static_cast<std::uint8_t>(forest_.level(leaf)); });
    }

  private:
    friend class detail::ForestFamily<TriangleFamily, TriangleForest>;

    void describe(LeafId leaf, LeafView& view) const {
        view.node = node(leaf);
        view.face = forest_.face(leaf);
        view.level = view.node.depth;
        view.corner_count = 3;
        view.leaf.slot = leaf;
        const auto points = forest_.points(leaf);
        for (std::size_t k = 0; k < 3; ++k) {
            view.point[k] = points[k];
            view.corner[k] = forest_.point_site(points[k]);
        }
    }
    // The triangle of a node, from the root down: child k keeps corner k, child 3 is the middle one, turned over.
    CellTriangle triangle(const HierarchyNode& node) const {
        LatticePoint at{};
        bool reversed = false;
        for (int d = 1; d <= node.depth; ++d) {
            const auto k = static_cast<unsigned>(node.path >> (64 - 2 * d) & 3);
            const std::uint32_t step = reversed ? ~std::uint32_t{0} : 1;
            at = {2 * at.x + (k & 1 ? step : 0), 2 * at.y + (k & 2 ? step : 0)};
            reversed ^= k == 3;
        }
        const std::uint32_t step = reversed ? ~std::uint32_t{0} : 1;
        return {mesh().face_halfedge(FaceId(node.root)), node.depth, {at, {at.x + step, at.y}, {at.x, at.y + step}}};
    }
};

}  // namespace

std::unique_ptr<HierarchyFamily> triangle_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source) {
    return std::make_unique<TriangleFamily>(mesh, std::move(source));
}

}  // namespace tetrakis
