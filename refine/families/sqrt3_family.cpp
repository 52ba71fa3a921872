#include "../../hier/base/memory.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "hierarchy_families.hpp"

#include <oneapi/tbb/parallel_sort.h>
#include <glm/gtc/bitfield.hpp>

#include <algorithm>
#include <cassert>
#include <string>
#include <tuple>
#include <utility>

namespace tetrakis {

namespace {

constexpr int k_side_bits = 2;
constexpr int k_finest_lattice = 19;  // of leaves, whose level is 37 at most (Sqrt3Lattice::max_level())

class Sqrt3Family final : public detail::TriangleForestFamily<Sqrt3Family, Sqrt3Forest, Sqrt3Triangle> {
  public:
    Sqrt3Family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source)
        : TriangleForestFamily(mesh, std::move(source), Sqrt3Forest(mesh),
                               {.child_count = 3,
                                .path_bits = k_side_bits,
                                .max_depth = 2 * sqrt3_tree_levels(mesh),
                                .root_bound = mesh.face_count(),
                                .halves = true}) {}

    std::string_view name() const override { return "sqrt3"; }

    std::string check_site(const Site& site) const override {
        if (site.root.value >= mesh().halfedge_count() || site.root.value % 3 != 0)
            return "its root is not the first half-edge of a face";
        if (site.level > sqrt3_lattice_level(source_->max_level()))
            return "its lattice level is above " + std::to_string(sqrt3_lattice_level(source_->max_level()));
        std::int64_t segments = 1;
        for (int l = 0; l < site.level; ++l) segments *= 3;
        const std::int64_t x = site.at.x, y = site.at.y;
        if (x + y > segments) return "its coordinates add up to more than 3^level";
        if (sqrt3_site(mesh(), mesh().face(site.root), {{segments - x - y, x, y}}, site.level) != site)
            return "it is not the canonical address of its vertex";
        return {};
    }

    HierarchyNode node(LeafId leaf) const override { return node_of(forest_.triangle(leaf)); }
    /// Leaves by the control face that they lie in (on an edge of two, the face whose number they have), then by their
    /// centres on a Z-order curve (Morton 1966) through the finest lattice. Leaves do not overlap, so centres differ.
    std::vector<LeafId> leaves_on_curve() const override {
        std::vector<std::tuple<std::uint32_t, std::uint64_t, LeafId>> places;
        detail::reserve_large(places, forest_.leaf_count());
        forest_.for_each_leaf([&](LeafId leaf, FaceId) {
            const Sqrt3Cell cell = forest_.lattice().cell(forest_.triangle(leaf));
            Sqrt3Point middle = cell.corner[0] + cell.corner[1] + cell.corner[2];  // 3^20 at most: less than 2^32
            for (int l = cell.lattice(); l < k_finest_lattice; ++l) middle = 3 * middle;
            assert(middle[0] >= 0 && middle[1] >= 0 && middle[2] >= 0);
            const auto x = static_cast<std::uint32_t>(middle[0]), y = static_cast<std::uint32_t>(middle[1]);
            places.emplace_back(cell.root.value, glm::bitfieldInterleave(x, y), leaf);
        });
        oneapi::tbb::parallel_sort(places.begin(), places.end());
        std::vector<LeafId> leaves;
        detail::reserve_large(leaves, places.size());
        for (const auto& [root, along, leaf] : places) leaves.push_back(leaf);
        return leaves;
    }
    std::optional<LeafId> find(const HierarchyNode& node) const override { return forest_.find(triangle(node)); }

    void refine(std::span<const LeafId> marked, bool with_removed, FamilyUpdate& update) override {
        Sqrt3Forest::Changed removed;
        forest_.refine(marked, update, with_removed ? &removed : nullptr);
        for (const auto& [leaf, before] : removed) update.removed.emplace_back(leaf, node_of(before));
    }
    void coarsen(std::span<const LeafId> marked, FamilyUpdate& update) override {
        Sqrt3Forest::Changed removed;
        forest_.coarsen(marked, update, removed);
        for (const auto& [leaf, before] : removed) update.removed.emplace_back(leaf, node_of(before));
    }
    std::vector<LeafId> diamond(LeafId leaf) const override { return forest_.group(leaf); }

    static FaceId face(std::uint32_t root) { return FaceId(root); }
    static std::uint8_t level(int depth) { return static_cast<std::uint8_t>((depth + 1) / 2); }
    std::array<Site, 4> corners(const HierarchyNode& node) const {
        const Sqrt3Cell cell = forest_.lattice().cell(triangle(node));
        const auto at = [&](std::size_t k) { return sqrt3_site(mesh(), cell.root, cell.corner[k], cell.lattice()); };
        return {at(0), at(1), at(2)};
    }
    void add_triangles(LeafId leaf, std::vector<Sqrt3Triangle>& list) const { list.push_back(forest_.triangle(leaf)); }
    // A whole triangle has half triangles as parents on both of its sides. Merging the splits on one side leaves that
    // side's triangle whole, and on the other side a half triangle.
    void node_errors(std::span<const HierarchyNode> nodes, const ErrorEstimator& estimator,
                     std::span<double> errors) const override {
        Sqrt3Lattice lattice = forest_.lattice();
        largest_errors(nodes, estimator, errors, [&](const HierarchyNode& node, auto& list) {
            const Sqrt3Triangle t = triangle(node);
            if (!t.half) return list.push_back(t);
            const auto above = static_cast<std::uint8_t>(t.level - 1);
            list.push_back({above, false, Sqrt3Lattice::face(t.face)});
            if (const std::uint64_t twin = lattice.twin(above, t.face); twin != Sqrt3Lattice::none)
                list.push_back({t.level, true, twin});
        });
    }

    static Sqrt3Triangle triangle(const HierarchyNode& node) {
        Sqrt3Triangle t{level(node.depth), node.depth % 2 != 0, node.root};
        for (int k = 1; k <= t.level; ++k) t.face = 3 * t.face + (node.path >> (64 - k_side_bits * k) & 3);
        return t;
    }

  private:
    static HierarchyNode node_of(const Sqrt3Triangle& t) {
        HierarchyNode node;
        std::uint64_t face = t.face;
        for (int k = t.level; k > 0; --k, face /= 3) node.path |= face % 3 << (64 - k_side_bits * k);
        node.root = static_cast<std::uint32_t>(face);
        node.depth = static_cast<std::uint8_t>(2 * t.level - (t.half ? 1 : 0));
        return node;
    }
};

}  // namespace

int sqrt3_tree_levels(const ControlMesh& mesh) { return std::min(64 / k_side_bits, Sqrt3Lattice::max_level(mesh)); }

std::unique_ptr<HierarchyFamily> sqrt3_family(const ControlMesh& mesh, std::shared_ptr<const LevelSource> source) {
    return std::make_unique<Sqrt3Family>(mesh, std::move(source));
}

}  // namespace tetrakis
