#pragma once

#include "../../hier/base/error.hpp"
#include "../../hier/forest/site.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "hierarchy_leaf.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

namespace tetrakis {

class VertexForest;
struct Sqrt3Triangle;

/// The evidence for an error.
enum class ErrorBasis : std::uint8_t {
    bound,    ///< a proven bound, if the estimator proves any; else unspecified
    samples,  ///< distances of sampled points
};

/// Decides where to refine: computes errors of a hierarchy's leaves, in the unit of the control mesh, for comparison
/// with the tolerance. An error depends only on the leaf and its part of the output mesh.
///
/// Families have different kinds of leaves. An estimator may support some of them only: the functions that it does not
/// override throw. HierarchyEstimator (eval) supports all families.
class ErrorEstimator {
  public:
    virtual ~ErrorEstimator() = default;
    /// Whether the estimator can measure leaves of a hierarchy over this mesh with such trees.
    virtual bool is_for(const ControlMesh& mesh, const HierarchyTree& tree) const {
        (void)mesh, (void)tree;
        return true;
    }
    /// Called with large batches, from several threads at once.
    /// @param triangles  triangles of the hierarchy (CellTriangle; quad family: depth-0 ones in their extended frame)
    /// @param errors     receives triangles.size() errors
    virtual void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const = 0;
    /// The same with the basis of each error: `bound`, unless an estimator overrides this function.
    virtual void estimate(std::span<const CellTriangle> triangles, std::span<double> errors,
                          std::span<ErrorBasis> basis) const {
        estimate(triangles, errors);
        std::ranges::fill(basis, ErrorBasis::bound);
    }
    /// Errors of triangles of the sqrt(3) scheme. Called from one thread, with all triangles at once.
    /// @throws Error  unsupported: not overridden
    virtual void estimate_sqrt3(std::span<const Sqrt3Triangle> triangles, std::span<double> errors) const {
        (void)triangles, (void)errors;
        refuse("triangles between points of binary lattices, and the vertices of sqrt3 lie elsewhere", "sqrt3");
    }
    /// estimate_sqrt3() with the basis of each error, which is always `bound`.
    void estimate(std::span<const Sqrt3Triangle> triangles, std::span<double> errors,
                  std::span<ErrorBasis> basis) const {
        estimate_sqrt3(triangles, errors);
        std::ranges::fill(basis, ErrorBasis::bound);
    }
    /// Errors of leaves of vertex quadtrees, each a vertex of the forest's mesh. Called from one thread, with all
    /// leaves at once.
    /// @throws Error  unsupported: not overridden
    virtual void estimate_vertices(const VertexForest& forest, std::span<const LeafId> leaves,
                                   std::span<double> errors) const {
        (void)forest, (void)leaves, (void)errors;
        refuse("triangles between lattice points, and a dual scheme's vertices lie between those", "vertices");
    }

  private:
    [[noreturn]] static void refuse(const std::string& measures, const std::string& other) {
        throw Error(ErrorCode::unsupported, "this estimator measures " + measures +
                                                "; take one that overrides estimate_" + other +
                                                "(), such as HierarchyEstimator, or a predicate");
    }
};

}  // namespace tetrakis
