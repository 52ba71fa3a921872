#pragma once

#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/families/error_estimator.hpp"

#include <limits>
#include <span>

namespace tetrakis {

/// How far the limit surface is from the mesh of a hierarchy's leaves (to_mesh(), its faces cut into triangles): an
/// estimator for refine_where() and coarsen_where() of every family.
///
///     hierarchy.refine_where(HierarchyEstimator(hierarchy, tolerance), tolerance, max_depth);
///
/// Errors come from limit points that later levels put on and between a leaf's edges ("vertices": over its cell, and
/// the error is that of the triangles around the vertex), on boundaries ("bisection", "triangles": hard creases, too)
/// from those along them, and are 6 % larger than what is seen there, for what lies between the points. No bound. None
/// for leaves inside holes, and for leaves so deep that the lattice ends before it has such points (2 levels on; sqrt3:
/// 6 simple steps), which are too small to be off by more than rounding.
///
/// Knows nothing of the leaves' history: one estimator does for any leaves of the hierarchy at any time. Cost: some 20
/// limit points a leaf; "vertices": one for each leaf that there is, too, a call. The same errors for any number of
/// threads.
class HierarchyEstimator final : public ErrorEstimator {
  public:
    /// @param hierarchy  gives the limit points (family "sqrt3": its mesh, by the scheme's rules); outlives the
    ///                   estimator
    /// @param tolerance  what errors will be compared with: of those above it, it is known only that they are, which
    ///                   is cheaper. 0: all are as seen
    HierarchyEstimator(const Hierarchy& hierarchy, double tolerance);
    HierarchyEstimator(const Hierarchy&&, double) = delete;

    /// Only those over the very same mesh, of the same family.
    bool is_for(const ControlMesh& mesh, const HierarchyTree& tree) const override {
        return &mesh == &hierarchy_.mesh() && tree == hierarchy_.tree();
    }
    /// @throws Error  unsupported: a limit that the scheme has no mask for
    using ErrorEstimator::estimate;
    void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const override;
    void estimate_sqrt3(std::span<const Sqrt3Triangle> triangles, std::span<double> errors) const override;
    void estimate_vertices(const VertexForest& forest, std::span<const LeafId> leaves,
                           std::span<double> errors) const override;

  private:
    const Hierarchy& hierarchy_;
    double aim_;  ///< seen errors above it are looked at no closer; 0: none
};

}  // namespace tetrakis
