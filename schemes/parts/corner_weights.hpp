#pragma once

#include "../core/masks.hpp"
#include "../core/rule_step.hpp"

#include <vector>

namespace tetrakis::detail {

/// Of a face of k corners, from the one itself on: what its new corner is made of. Circulant, with sum 1.
using CornerWeights = std::vector<double> (*)(int k);

/// Those of the faces of a mesh.
class FaceWeights {
  public:
    FaceWeights(const RuleMesh& mesh, CornerWeights weights);
    /// Adds the new corner of a face at the origin of its half-edge.
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

/// Of a new boundary or crease point: the near and the far end of its edge (Chaikin's rule).
struct ChaikinWeights {
    static constexpr double near_end = 3.0 / 4, far_end = 1.0 / 4;
};

/// One step of the dual scheme with those weights. Boundary: edge replication, which gives the quadratic B-spline of
/// the boundary polygon; a crease is a boundary on each side; a corner (three or more sharp edges, or a tagged vertex
/// on a crease or boundary) stays where it is, by replicating the vertex as well; tags on other vertices have no
/// effect.
RuleStep corner_weights_step(const RuleMesh& mesh, const RuleOptions& options, CornerWeights weights);

/// Limit of a face: its centroid, with the cos / sin tangents of its corners. At a boundary: the midpoint of an edge,
/// along p_1 - p_0, across from the edge to the next row (at eigenvalue 1/4: the parametrisation stops there, the
/// surface has a tangent plane).
ClosedMasks corner_weights_closed_masks(const FanShape& shape, const RuleOptions&);

}  // namespace tetrakis::detail
