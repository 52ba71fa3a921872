#include "../../hier/base/memory.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "hierarchy_families.hpp"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

namespace tetrakis {

namespace {

constexpr int k_path_bits = 2;

VertexCell ancestor(const VertexCell& cell, int level) {
    const int up = cell.level - level;
    return {cell.root, {cell.at.x >> up, cell.at.y >> up}, static_cast<std::uint8_t>(level)};
}

/// Refines a forest of roots until the cells, all of one level, and all cells that touch them are leaves of that level.
/// @param leaves  receives the leaves of `cells`, in their order
void refine_towards(VertexForest& forest, std::span<const VertexCell> cells, std::vector<LeafId>& leaves) {
    std::vector<VertexCell> touching;
    for (const VertexCell& cell : cells)
        for (const VertexCell& side : forest.roots().sides(cell))
            for (int k = 0; k < 4; ++k)
                for (const VertexRoots::Corner& c : forest.roots().fan({side, k}).corners) touching.push_back(c.cell);
    ForestChange change;
    change.created = forest.ordered_leaves();
    std::vector<LeafId> marked;
    for (int level = 0; level < cells.front().level; ++level) {
        std::vector<VertexCell> above;
        for (const VertexCell& cell : touching) above.push_back(ancestor(cell, level));
        std::sort(above.begin(), above.end());
        marked.clear();
        for (const LeafId leaf : change.created)
            if (std::binary_search(above.begin(), above.end(), forest.cell(leaf))) marked.push_back(leaf);
        forest.refine(marked, change);
    }
    std::vector<std::pair<VertexCell, LeafId>> found;
    for (const LeafId leaf : change.created) found.emplace_back(forest.cell(leaf), leaf);
    std::sort(found.begin(), found.end());
    for (const VertexCell& cell : cells)
        leaves.push_back(std::lower_bound(found.begin(), found.end(), std::pair(cell, LeafId(0)))->second);
}

class VertexFamily final : public detail::ForestFamily<VertexFamily, VertexForest> {
  public:
    VertexFamily(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source, VertexRoots roots)
        : ForestFamily(mesh, std::move(source), VertexForest(std::move(roots)),
                       {.child_count = 4, .path_bits = k_path_bits, .max_depth = k_max_level}) {
        tree_.root_bound = forest_.roots().count();
    }

    std::string_view name() const override { return "vertices"; }
    std::unique_ptr<HierarchyFamily> fresh() const override {
        return std::make_unique<VertexFamily>(mesh_, source_, forest_.roots());
    }

    std::string check_site(const Site& site) const override {
        if (site.root.value >= tree_.root_bound)
            return "its root is " + std::to_string(site.root.value) + ", but there are " +
                   std::to_string(tree_.root_bound);
        if (site.level > k_max_level) return "its lattice level is above " + std::to_string(k_max_level);
        if (site.at.x >> site.level != 0 || site.at.y >> site.level != 0)
            return "its cell's coordinates are not below 2^level";
        return {};
    }
    bool has_root(std::uint32_t root) const override { return root < tree_.root_bound; }

    HierarchyNode node(LeafId leaf) const override { return node_in_tree(leaf); }
    NodeView view(const HierarchyNode& node) const override {
        NodeView view;
        describe(node, cell_of(node), view);
        return view;
    }

    void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) override {
        forest_.refine(marked, update);
        if (with_removed) list_parents(update);
        list_reshaped(update, true);
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override {
        forest_.coarsen(marked, update);
        list_reshaped(update, false);
    }
    std::vector<LeafId> diamond(LeafId leaf) const override { return forest_.mergeable_siblings(leaf); }

    void leaf_errors(std::span<const LeafId> leaves, const ErrorEstimator& estimator,
                     std::span<double> errors) const override {
        estimator.estimate_vertices(forest_, leaves, errors);
    }
    // Level by level: a temporary forest holds the wanted cells of one level and their neighbours.
    void node_errors(std::span<const HierarchyNode> nodes, const ErrorEstimator& estimator,
                     std::span<double> errors) const override {
        std::vector<std::size_t> order(nodes.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return nodes[a].depth < nodes[b].depth; });
        std::vector<VertexCell> cells;
        std::vector<LeafId> leaves;
        std::vector<double> found;
        for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
            cells.clear();
            while (end < order.size() && nodes[order[end]].depth == nodes[order[begin]].depth)
                cells.push_back(cell_of(nodes[order[end++]]));
            VertexForest forest(forest_.roots());
            leaves.clear();
            refine_towards(forest, cells, leaves);
            found.resize(leaves.size());
            estimator.estimate_vertices(forest, leaves, found);
            for (std::size_t i = begin; i < end; ++i) errors[order[i]] = found[i - begin];
        }
    }

    HierarchyMesh faces(std::vector<std::uint8_t>& diagonal_at_first) const override {
        DualFaces dual = forest_.faces();
        HierarchyMesh result;
        result.sites = cell_sites(dual.cells);
        detail::reserve_large(result.points, dual.leaves.size());
        for (const LeafId leaf : dual.leaves) result.points.emplace_back(leaf.value);
        detail::reserve_large(result.leaves, dual.control_faces.size());
        for (std::size_t f = 0; f < dual.control_faces.size(); ++f)
            result.leaves.push_back({dual.leaves[dual.face_vertices[dual.face_offsets[f]]]});
        result.mesh.face_offsets = std::move(dual.face_offsets);
        result.mesh.face_vertices = std::move(dual.face_vertices);
        result.faces = std::move(dual.control_faces);
        diagonal_at_first = std::move(dual.diagonal_at_first);
        return result;
    }

    void describe(LeafId leaf, LeafView& view) const {
        describe(node(leaf), forest_.cell(leaf), view);
        view.leaf.slot = leaf;
        view.point[0] = PointId(forest_.vertex_leaf(leaf).value);
    }

  private:
    VertexCell cell_of(const HierarchyNode& node) const { return VertexForest::cell(frame(node)); }
    void describe(const HierarchyNode& node, const VertexCell& cell, NodeView& view) const {
        view.node = node;
        view.face = forest_.roots().face[cell.root];
        view.level = static_cast<std::uint8_t>(cell.level + 1);
        view.corner_count = 1;
        view.side_count = 4;
        view.corner[0] = cell_site(cell);
    }
    /// Lists the older leaves that share a point with new ones: the face at such a point is new or has changed.
    /// @param siblings  whether the new leaves are groups of four siblings
    void list_reshaped(FamilyUpdate& update, bool siblings) {
        std::vector<LeafId>& list = update.reshaped;
        list.clear();
        if (update.created.size() == forest_.leaf_count()) return;  // there are no others
        seen_.resize(std::max<std::size_t>(seen_.size(), forest_.leaf_slots()), 0);
        for (const LeafId leaf : update.created) seen_[leaf.value] = 1;
        std::vector<LeafId> around;
        const auto add_around = [&] {
            for (const LeafId leaf : around)
                if (leaf.valid() && std::exchange(seen_[leaf.value], 1) == 0) list.push_back(leaf);
            around.clear();
        };
        for (const LeafId leaf : update.created) {
            const VertexCell cell = forest_.cell(leaf);
            const int right = static_cast<int>(cell.at.x & 1), child = (cell.at.y & 1) != 0 ? 3 - right : right;
            for (int k = 0; k < 4; ++k) {
                // A sibling's own corner is its parent's. Leaves at its other corners lie across its sides, too.
                if (!siblings || k == child) forest_.add_leaves_around(leaf, k, around);
                if (siblings && k != child && k != (child + 3) % 4) continue;
                const std::array<LeafId, 2> across = forest_.neighbours(leaf, k);
                around.insert(around.end(), across.begin(), across.end());
            }
            add_around();
        }
        // A face that changed on one side of a crease belongs to the crease vertex, which has a leaf on each side.
        for (std::size_t i = 0, count = list.size(); i < count; ++i) {
            forest_.add_other_sides(list[i], around);
            add_around();
        }
        std::sort(list.begin(), list.end());
        for (const auto* marked : {&update.created, &list})
            for (const LeafId leaf : *marked) seen_[leaf.value] = 0;
    }

    std::vector<std::uint8_t> seen_;  // per slot; zero between calls
};

}  // namespace

std::unique_ptr<HierarchyFamily> vertex_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source,
                                               VertexRoots roots) {
    return std::make_unique<VertexFamily>(mesh, std::move(source), std::move(roots));
}

}  // namespace tetrakis
