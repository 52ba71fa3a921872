#pragma once

#include "../../hier/base/memory.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/check.hpp"
#include "../../hier/forest/exported_triangles.hpp"
#include "../../hier/trees/tree_forest.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "hierarchy_family.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace tetrakis {

/// The family of quad schemes: a 4-8 bisection forest over corner cells; see Hierarchy. Keeps a reference to the mesh.
/// @param source  points over corner cells: lattice level l is scheme level l + 1
std::unique_ptr<HierarchyFamily> bisection_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source);

/// The family of triangle schemes: triangle quadtrees with red-green closure; see Hierarchy.
/// @param source  points over face triangles: lattice level l is scheme level l
/// @throws Error  unsupported: a face is not a triangle
std::unique_ptr<HierarchyFamily> triangle_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source);

/// The family of dual schemes: vertex quadtrees; see Hierarchy. Keeps a reference to the mesh.
/// @param source  points over the cells of `roots`, addressed by sites (cell_site())
std::unique_ptr<HierarchyFamily> vertex_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source,
                                               VertexRoots roots);

/// The family of the sqrt(3) scheme: triangles split at their centres and flipped; see Hierarchy. Keeps a reference to
/// the mesh.
/// @param source  points over the sites of sqrt3_levels()
/// @throws Error  as Sqrt3Forest
std::unique_ptr<HierarchyFamily> sqrt3_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source);
/// Largest level that its paths have bits for: 32, or less on a mesh whose level 32 has more than 2^64 half-edges.
int sqrt3_tree_levels(const ControlMesh& mesh);

/// Base classes of the families.
namespace detail {

/// The part of a family that is the same for every forest. It holds the forest. `Family` must have describe(leaf,
/// view), which fills all of a view but the handle's generation; views() calls it without a virtual call for each leaf.
template <class Family, class Forest>
class ForestFamily : public HierarchyFamily {
  public:
    std::uint32_t leaf_slots() const final { return forest_.leaf_slots(); }
    std::uint32_t leaf_count() const final { return forest_.leaf_count(); }
    bool is_leaf(LeafId slot) const final { return forest_.is_leaf(slot); }
    std::uint32_t point_slots() const final {
        if constexpr (requires { std::declval<const Forest&>().point_slots(); })
            return forest_.point_slots();
        else
            return forest_.leaf_slots();  // leaves are vertices
    }
    std::array<LeafId, 2> neighbours(LeafId leaf, int side) const final { return forest_.neighbours(leaf, side); }
    std::vector<LeafId> ordered_leaves() const final { return forest_.ordered_leaves(); }

    using HierarchyFamily::view;
    LeafView view(LeafId leaf) const final {
        LeafView view;
        self().describe(leaf, view);
        return view;
    }
    void views(std::span<const LeafId> leaves, std::span<LeafView> views) const final {
        for (std::size_t i = 0; i < leaves.size(); ++i) self().describe(leaves[i], views[i]);
    }

    std::optional<std::string> check() const final { return check_forest(forest_); }
    std::uint64_t memory_bytes() const final { return forest_.memory_bytes(); }
    void shrink() final { forest_.shrink(); }
    bool has_free_slots() const final { return forest_.has_free_slots(); }

  protected:
    ForestFamily(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source, Forest forest,
                 const HierarchyTree& tree)
        : HierarchyFamily(mesh, std::move(source), tree), forest_(std::move(forest)) {}

    // For forests that are quadtrees (TreeForest): the node of a leaf, and the frame of a node.
    HierarchyNode node_in_tree(LeafId leaf) const {
        return tree_.node(forest_.root(leaf), forest_.path(leaf), forest_.level(leaf));
    }
    TreeFrame frame(const HierarchyNode& node) const {
        return forest_.frame(node.root, tree_.low_path(node), node.depth);
    }
    /// Lists the parents of the new leaves of a refinement that created them in groups of four.
    void list_parents(FamilyUpdate& update) const {
        for (std::size_t i = 0; i < update.created.size(); i += 4)
            update.removed.emplace_back(forest_.parent(update.created[i]), tree_.parent(node(update.created[i])));
    }

    Forest forest_;

  private:
    const Family& self() const { return static_cast<const Family&>(*this); }
};

/// The same for families whose leaves consist of triangles, over forests that store their points' sites. `Family` must
/// have add_triangles(leaf, list), which adds the triangles whose errors count; triangle(node); and for views
/// face(root), level(depth) and corners(node).
template <class Family, class Forest, class Triangle>
class TriangleForestFamily : public ForestFamily<Family, Forest> {
  public:
    std::unique_ptr<HierarchyFamily> fresh() const final {
        return std::make_unique<Family>(this->mesh_, this->source_);
    }

    bool has_root(std::uint32_t root) const final { return !this->mesh_.is_hole(self().face(root)); }
    using ForestFamily<Family, Forest>::view;
    NodeView view(const HierarchyNode& node) const final {
        NodeView view = view_without_corners(node);
        view.corner = self().corners(node);
        return view;
    }
    void describe(LeafId leaf, LeafView& view) const {
        static_cast<NodeView&>(view) = view_without_corners(self().node(leaf));
        view.leaf.slot = leaf;
        std::ranges::copy(this->forest_.points(leaf), view.point.begin());
        for (std::size_t k = 0; k < 3; ++k) view.corner[k] = this->forest_.point_site(view.point[k]);
    }

    void leaf_errors(std::span<const LeafId> leaves, const ErrorEstimator& estimator,
                     std::span<double> errors) const final {
        largest_errors(leaves, estimator, errors, [&](LeafId leaf, auto& list) { self().add_triangles(leaf, list); });
    }
    void node_errors(std::span<const HierarchyNode> nodes, const ErrorEstimator& estimator,
                     std::span<double> errors) const override {
        largest_errors(nodes, estimator, errors,
                       [&](const HierarchyNode& node, auto& list) { list.push_back(self().triangle(node)); });
    }

    HierarchyMesh faces(std::vector<std::uint8_t>& /*diagonal_at_first*/) const final {
        ExportedTriangles exported = this->forest_.exported();
        const auto count = static_cast<std::uint32_t>(exported.triangles.size());
        HierarchyMesh result;
        resize_large(result.mesh.face_offsets, count + std::size_t{1});
        for_each_index(count + 1, [&](std::uint32_t t) { result.mesh.face_offsets[t] = 3 * t; });
        // Appended: resizing first would write all of them twice.
        reserve_large(result.mesh.face_vertices, 3 * std::size_t{count});
        for (const auto& triangle : exported.triangles)
            result.mesh.face_vertices.insert(result.mesh.face_vertices.end(), triangle.begin(), triangle.end());
        reserve_large(result.leaves, count);
        for (const LeafId leaf : exported.leaves) result.leaves.push_back({leaf});
        result.faces = std::move(exported.faces);
        result.sites = std::move(exported.sites);
        result.points = std::move(exported.points);
        return result;
    }

  protected:
    using ForestFamily<Family, Forest>::ForestFamily;

    /// For each item, the largest error of its triangles.
    /// @param add  add(item, list) appends the item's triangles to the list
    template <class Item, class Add>
    static void largest_errors(std::span<const Item> items, const ErrorEstimator& estimator, std::span<double> errors,
                               const Add& add) {
        const auto count = static_cast<std::uint32_t>(items.size());
        // estimate_sqrt3() must get all triangles in one call.
        const std::uint32_t block = std::is_same_v<Triangle, CellTriangle> ? 1024 : std::max(count, 1u);
        for_each_block(count, block, [&](std::uint32_t begin, std::uint32_t end) {
            std::vector<Triangle> triangles;
            std::vector<std::size_t> ends;
            for (std::uint32_t i = begin; i < end; ++i) {
                add(items[i], triangles);
                ends.push_back(triangles.size());
            }
            std::vector<double> values(triangles.size());
            std::vector<ErrorBasis> basis(triangles.size());
            estimator.estimate(triangles, values, basis);
            std::size_t t = 0;
            for (std::uint32_t i = begin; i < end; ++i)
                // Not std::max: a NaN error must not be lost.
                for (errors[i] = 0; t < ends[i - begin]; ++t)
                    if (!(values[t] <= errors[i]) && !std::isnan(errors[i])) errors[i] = values[t];
        });
    }

  private:
    const Family& self() const { return static_cast<const Family&>(*this); }
    NodeView view_without_corners(const HierarchyNode& node) const {
        return {.node = node, .face = self().face(node.root), .level = self().level(node.depth), .corner_count = 3};
    }
};

}  // namespace detail

}  // namespace tetrakis
