#include "error_estimator.hpp"

#include "../../hier/base/error.hpp"

namespace tetrakis {

void ErrorEstimator::estimate_sqrt3(std::span<const Sqrt3Triangle>, std::span<double>) const {
    throw Error(ErrorCode::unsupported,
                "this estimator measures triangles between points of binary lattices, and the vertices of sqrt3 lie "
                "elsewhere; take one that overrides estimate_sqrt3(), such as HierarchyEstimator, or a predicate");
}

void ErrorEstimator::estimate_vertices(const VertexForest&, std::span<const LeafId>, std::span<double>) const {
    throw Error(ErrorCode::unsupported,
                "this estimator measures triangles between lattice points, and a dual scheme's vertices lie between "
                "those; take one that overrides estimate_vertices(), such as HierarchyEstimator, or a predicate");
}

}  // namespace tetrakis
