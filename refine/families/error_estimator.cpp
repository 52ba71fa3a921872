#include "error_estimator.hpp"

#include "../../hier/base/error.hpp"

#include <algorithm>

namespace tetrakis {

void ErrorEstimator::estimate(std::span<const CellTriangle> triangles, std::span<double> errors,
                              std::span<ErrorBasis> basis) const {
    estimate(triangles, errors);
    std::ranges::fill(basis, ErrorBasis::bound);
}

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
