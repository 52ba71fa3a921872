#pragma once

#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/families/error_estimator.hpp"

#include <span>

namespace tetrakis {

/// How far the limit surface is from the mesh of a hierarchy's leaves (to_mesh(), its faces cut into triangles): an
/// estimator for refine_where() and coarsen_where() of every family.
///
///     hierarchy.refine_where(HierarchyEstimator(hierarchy, tolerance), tolerance, max_depth);
///
/// An error is the largest distance of the limit points that two more levels put on a leaf's edges and inside it. On
/// boundaries ("bisection", "triangles": also hard creases) they are compared with the leaf's own edge. For "vertices"
/// the points lie over the leaf's cell, and the error is that of the triangles around the vertex. As the surface may be
/// farther off between these points, errors are divided by 0.94 (interpolating schemes: 0.9); they are no bounds. The
/// error is 0 inside holes, and for leaves so deep that the lattice ends before (2 levels; sqrt3: 6 simple steps).
///
/// Errors depend on the leaves only, so one estimator can be used again after changes; they are the same for any number
/// of threads. Cost: some 20 limit points a leaf; "vertices": also one, in each call, for each leaf of the hierarchy.
class HierarchyEstimator final : public ErrorEstimator {
  public:
    /// @param hierarchy  gives the limit points (family "sqrt3": its mesh, by the scheme's rules); outlives the
    ///                   estimator
    /// @param tolerance  errors are only as exact as a comparison with it needs, which is cheaper. 0: all errors are
    ///                   estimated fully
    HierarchyEstimator(const Hierarchy& hierarchy, double tolerance);
    HierarchyEstimator(const Hierarchy&&, double) = delete;

    /// True for leaves of the same family over the same mesh object.
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
    double aim_;  ///< errors of samples above it are final; 0: none are
};

}  // namespace tetrakis
