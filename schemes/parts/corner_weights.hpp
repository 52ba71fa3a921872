#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis::detail {

/// Weights of a k-gon's corners in one of its new corners, from the old corner there on. Circulant, with sum 1.
using CornerWeights = std::vector<double> (*)(int k);

/// Corner weights for all faces of a mesh, computed once per size.
class FaceWeights {
  public:
    FaceWeights(const RuleMesh& mesh, CornerWeights weights);
    /// Adds `weight` times the new corner that the face of `h` has at the origin of `h`.
    void add_corner(int h, double weight, StencilRow& row) const {
        const std::vector<double>& of = of_size_[mesh_.face_size(mesh_.face(h))];
        for (const double w : of) {
            row.add(mesh_.origin(h), weight * w);
            h = mesh_.next(h);
        }
    }

  private:
    const RuleMesh& mesh_;
    std::vector<std::vector<double>> of_size_;
};

/// Weights of the near and the far end of an edge in a new boundary or crease point (Chaikin's rule).
struct ChaikinWeights {
    static constexpr double near_end = 3.0 / 4, far_end = 1.0 / 4;
};

/// One step of the dual scheme with the given corner weights. Edges of the boundary are replicated, which gives the
/// quadratic B-spline of the boundary polygon. A crease is a boundary on each side. A corner (three or more sharp
/// edges, or a tagged vertex on a crease or boundary) is replicated as well, so it stays where it is. Tags on other
/// vertices have no effect.
RuleStep corner_weights_step(const RuleMesh& mesh, const RuleOptions& options, CornerWeights weights);

/// Limit of a face: its centroid, with the cos / sin tangents of its corners. At a boundary: the midpoint of an edge;
/// the tangents are p_1 - p_0 along it, and the step to the next row of points across it. The latter's eigenvalue is
/// 1/4, so the derivative of the parametrisation is zero there, but the surface has a tangent plane.
ClosedMasks corner_weights_closed_masks(const FanShape& shape, const RuleOptions&);

}  // namespace tetrakis::detail
