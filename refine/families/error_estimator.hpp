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

/// What an error rests on.
enum class ErrorBasis : std::uint8_t {
    bound,    ///< a proven bound, where its estimator proves any; else not said
    samples,  ///< distances of sampled points
};

/// Decides where to refine: gives the leaves of a hierarchy errors, in the unit of the control mesh, to be compared
/// with the tolerance. An error depends on the leaf and its part of the output mesh alone.
///
/// Families differ in what a leaf is. An estimator of its own may leave out those that it is not for: the functions
/// that are not overridden refuse. HierarchyEstimator (eval) takes them all.
class ErrorEstimator {
  public:
    virtual ~ErrorEstimator() = default;
    /// Whether it can look at leaves of a hierarchy over this mesh with such trees.
    virtual bool is_for(const ControlMesh& mesh, const HierarchyTree& tree) const {
        (void)mesh, (void)tree;
        return true;
    }
    /// Called with large batches, from several threads at once.
    /// @param triangles  triangles of the hierarchy (CellTriangle; quad family: depth-0 ones in their extended frame)
    /// @param errors     receives triangles.size() errors
    virtual void estimate(std::span<const CellTriangle> triangles, std::span<double> errors) const = 0;
    /// The same with the basis of each error: `bound`, unless an estimator overrides this.
    virtual void estimate(std::span<const CellTriangle> triangles, std::span<double> errors,
                          std::span<ErrorBasis> basis) const {
        estimate(triangles, errors);
        std::ranges::fill(basis, ErrorBasis::bound);
    }
    /// Triangles of the sqrt(3) scheme; from one thread, all that are wanted at a time together.
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
    /// Leaves of vertex quadtrees, as vertices of the forest's mesh; from one thread, all that are wanted at a time
    /// together.
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
