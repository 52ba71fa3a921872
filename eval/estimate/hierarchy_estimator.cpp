#include "hierarchy_estimator.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../hier/trees/sqrt3_lattice.hpp"
#include "../../hier/trees/vertex_roots.hpp"
#include "../bounds/dual_leaf_error.hpp"
#include "../distance/limit_samples.hpp"
#include "limit_estimator.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace tetrakis {

namespace {

/// Errors of leaves for which later levels have points; 0 for the other leaves.
/// @param reaches   reaches(leaf): whether later levels have points for it
/// @param estimate  estimate(leaves, errors): largest distances of these points
template <class Leaf, class Reaches, class Estimate>
void estimate_reached(const SchemeInfo& scheme, std::span<const Leaf> leaves, std::span<double> errors,
                      Reaches&& reaches, Estimate&& estimate) {
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
    for (std::size_t i = 0; i < seen.size(); ++i) errors[place[i]] = seen[i] / detail::seen_share(scheme);
}

}  // namespace

HierarchyEstimator::HierarchyEstimator(const Hierarchy& hierarchy, double tolerance)
    : hierarchy_(hierarchy), aim_(detail::seen_share(hierarchy.scheme()) * tolerance) {}

void HierarchyEstimator::estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const {
    estimate_reached(
        hierarchy_.scheme(), triangles, errors,
        [](const CellTriangle& t) { return t.level + detail::k_limit_lattice_bits <= k_max_level; },
        [&](std::span<const CellTriangle> reached, std::span<double> seen) {
            detail::LimitEstimator(hierarchy_, aim_).estimate(reached, seen);
        });
}

void HierarchyEstimator::estimate_sqrt3(std::span<const Sqrt3Triangle> triangles, std::span<double> errors) const {
    const int deepest = Sqrt3Lattice::max_level(hierarchy_.mesh()) - detail::k_sqrt3_error_steps;
    estimate_reached(
        hierarchy_.scheme(), triangles, errors, [&](const Sqrt3Triangle& leaf) { return leaf.level <= deepest; },
        [&](std::span<const Sqrt3Triangle> reached, std::span<double> seen) {
            const Sqrt3Lattice lattice(hierarchy_.mesh());
            detail::LimitEstimator(hierarchy_, aim_, &lattice).estimate_sqrt3(reached, seen);
        });
}

void HierarchyEstimator::estimate_vertices(const VertexForest& forest, std::span<const LeafId> leaves,
                                           std::span<double> errors) const {
    const detail::DualTriangles mesh = detail::dual_triangles(forest);
    constexpr std::uint32_t k_none = 0xFFFF'FFFFu;
    std::vector<std::uint32_t> vertex_of(forest.leaf_slots(), k_none);
    for (const auto& [vertex, leaf] : mesh.leaves()) vertex_of[leaf.value] = vertex;
    estimate_reached(
        hierarchy_.scheme(), leaves, errors,
        [&](LeafId leaf) {
            return forest.level(leaf) + detail::DualLeafErrors::k_bits <= k_max_level &&
                   forest.roots().hole[forest.cell(leaf).root] == 0 && vertex_of[leaf.value] != k_none;
        },
        [&](std::span<const LeafId> reached, std::span<double> seen) {
            std::vector<DualFaces::LeafOfVertex> asked;
            for (const LeafId leaf : reached) asked.push_back({vertex_of[leaf.value], leaf});
            detail::DualLeafErrors surface([&](std::span<const Site> sites, std::span<Vec3d> points) {
                hierarchy_.limit_positions(sites, points);
            });
            const auto no_report = [](double) {};
            const std::vector<Vec3d> positions = surface.positions(forest, mesh, no_report);
            std::ranges::copy(surface.errors(forest, mesh, positions, asked, no_report), seen.begin());
        });
}

}  // namespace tetrakis
