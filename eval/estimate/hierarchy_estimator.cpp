#include "hierarchy_estimator.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../bounds/dual_leaf_error.hpp"
#include "limit_estimator.hpp"
#include "sqrt3_leaf_error.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace tetrakis {

namespace {

/// What is seen is at least this share of the error: the surface may be a little farther between the points, 4 % on
/// coarse leaves of the models of the tests. Nothing is measured and split afterwards, as tessellate() does.
constexpr double k_seen = 0.94;

/// Errors of those leaves that later levels have points of; none for the others.
/// @param reaches   reaches(leaf): whether they have
/// @param estimate  estimate(leaves, errors)
template <class Leaf, class Reaches, class Estimate>
void estimate_reached(std::span<const Leaf> leaves, std::span<double> errors, Reaches&& reaches, Estimate&& estimate) {
    std::vector<Leaf> reached;
    std::vector<std::size_t> place;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        errors[i] = 0;
        if (!reaches(leaves[i])) continue;
        reached.push_back(leaves[i]);
        place.push_back(i);
    }
    std::vector<double> seen(reached.size());
    estimate(std::span<const Leaf>(reached), std::span<double>(seen));
    for (std::size_t i = 0; i < seen.size(); ++i) errors[place[i]] = seen[i] / k_seen;
}

/// Leaves of vertex quadtrees, with what of the mesh lies around them.
class DualProbe {
  public:
    DualProbe(const Hierarchy& hierarchy, const VertexForest& forest)
        : hierarchy_(hierarchy), forest_(forest), mesh_(detail::dual_triangles(forest)) {}

    void errors(std::span<const LeafId> leaves, double decide_at, std::span<double> errors) {
        std::vector<std::uint32_t> vertex_of(forest_.leaf_slots(), k_none);
        for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) vertex_of[mesh_.faces.leaves[v].value] = v;
        for (const DualFaces::OtherSide& side : mesh_.faces.other_sides) vertex_of[side.leaf.value] = side.vertex;
        std::vector<Asked> asked;
        for (std::size_t i = 0; i < leaves.size(); ++i) {
            errors[i] = 0;
            const std::uint32_t v = vertex_of[leaves[i].value];
            if (v != k_none && forest_.roots().hole[forest_.cell(leaves[i]).root] == 0)
                asked.push_back({v, leaves[i], &errors[i]});
        }
        find_positions(asked);
        look(asked, 1);
        std::erase_if(asked, [&](const Asked& a) { return *a.error > decide_at; });
        look(asked, k_most_bits);
    }

    static constexpr int k_most_bits = 2;  ///< levels below a leaf that are looked at

  private:
    static constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
    struct Asked {
        std::uint32_t vertex;
        LeafId leaf;  ///< on a crease the side of it that is asked for
        double* error;
    };

    std::vector<Vec3d> limits(std::span<const VertexCell> cells) const {
        std::vector<Vec3d> points(cells.size());
        hierarchy_.limit_positions(cell_sites(cells), points);
        return points;
    }
    /// Of the vertices that errors are measured by.
    void find_positions(std::span<const Asked> asked) {
        std::vector<std::uint8_t> needed(mesh_.vertex_count(), 0);
        for (const Asked& a : asked) {
            for (std::uint32_t i = mesh_.around_begin[a.vertex]; i < mesh_.around_begin[a.vertex + std::size_t{1}]; ++i)
                for (const std::uint32_t v : mesh_.triangle(mesh_.around[i])) needed[v] = 1;
            for (const std::uint32_t v : mesh_.beside[a.vertex]) needed[v] = 1;
        }
        std::vector<VertexCell> cells;
        for (std::uint32_t v = 0; v < needed.size(); ++v)
            if (needed[v] != 0) cells.push_back(mesh_.faces.cells[v]);
        const std::vector<Vec3d> points = limits(cells);
        positions_.resize(needed.size());
        for (std::uint32_t v = 0, next = 0; v < needed.size(); ++v)
            if (needed[v] != 0) positions_[v] = points[next++];
    }
    /// Raises the errors to those by the points so many levels down.
    void look(std::span<const Asked> asked, int bits) const {
        std::vector<VertexCell> cells;
        for (const Asked& a : asked) detail::add_cells_below(forest_.cell(a.leaf), bits, cells);
        const std::vector<Vec3d> points = limits(cells);
        const std::size_t each = std::size_t{1} << (2 * bits);
        constexpr std::uint32_t k_grain = 64;
        for_each_index(
            static_cast<std::uint32_t>(asked.size()),
            [&](std::uint32_t i) {
                const double seen = detail::dual_leaf_error(forest_, mesh_, positions_, asked[i].vertex, asked[i].leaf,
                                                            bits, std::span(points).subspan(i * each, each));
                if (!(seen <= *asked[i].error)) *asked[i].error = seen;
            },
            k_grain);
    }

    const Hierarchy& hierarchy_;
    const VertexForest& forest_;
    detail::DualTriangles mesh_;
    std::vector<Vec3d> positions_;  ///< per vertex, where needed
};

}  // namespace

HierarchyEstimator::HierarchyEstimator(const Hierarchy& hierarchy, double tolerance)
    : hierarchy_(hierarchy), aim_(k_seen * tolerance) {}

void HierarchyEstimator::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    estimate_reached(
        triangles, errors, [](const CellTriangle& t) { return t.level + detail::k_limit_lattice_bits <= k_max_level; },
        [&](std::span<const CellTriangle> reached, std::span<double> seen) {
            if (hierarchy_.family() == "triangles")
                LimitEstimator<LoopFamily>(hierarchy_, aim_).estimate(reached, seen);
            else
                LimitEstimator<QuadFamily>(hierarchy_, aim_).estimate(reached, seen);
        });
}

void HierarchyEstimator::estimate_sqrt3(std::span<const Sqrt3Triangle> triangles, std::span<double> errors) const {
    const int deepest = Sqrt3Lattice::max_level(hierarchy_.mesh()) - detail::k_sqrt3_error_steps;
    estimate_reached(
        triangles, errors, [&](const Sqrt3Triangle& leaf) { return leaf.level <= deepest; },
        [&](std::span<const Sqrt3Triangle> reached, std::span<double> seen) {
            const std::vector<double> found = detail::sqrt3_leaf_errors(hierarchy_, Sqrt3Lattice(hierarchy_.mesh()),
                                                                        reached, decide_at(), [](double) {});
            std::copy(found.begin(), found.end(), seen.begin());
        });
}

void HierarchyEstimator::estimate_vertices(const VertexForest& forest, std::span<const LeafId> leaves,
                                           std::span<double> errors) const {
    estimate_reached(
        leaves, errors, [&](LeafId leaf) { return forest.level(leaf) + DualProbe::k_most_bits <= k_max_level; },
        [&](std::span<const LeafId> reached, std::span<double> seen) {
            DualProbe(hierarchy_, forest).errors(reached, decide_at(), seen);
        });
}

}  // namespace tetrakis
