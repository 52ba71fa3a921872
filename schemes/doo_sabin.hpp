#pragma once

#include "tetrakis/schemes/closed_masks.hpp"
#include "tetrakis/schemes/rule_step.hpp"

#include <vector>

namespace tetrakis {

/// The dual schemes with one rule: the new corner of a k-gon from its k corners, from the corner itself on.
/// Sources: Doo, Sabin 1978; Catmull, Clark 1978 (their weights for it); Peters, Reif 1997 and Habib, Warren 1995
/// (midedge).
struct DooSabin {
    /// 1/4 + 5/(4k), then (3 + 2 cos(2 pi i / k)) / (4k). Eigenvalues of the k-gon: 1, 1/2 twice, 1/4.
    static std::vector<double> weights(int k);
    /// Catmull and Clark's: the corner 1/2, its neighbours 1/8, and 1/(4k) for all. Subdominant 1/2 + cos(2 pi / k)
    /// / 4.
    static std::vector<double> weights_catmull_clark(int k);
    /// Of a new boundary or crease point: the near and the far end of its edge (Chaikin's rule).
    static constexpr double crease_near = 3.0 / 4, crease_far = 1.0 / 4;
};

struct Midedge {
    /// (1 + 2 sum 2^(-j) cos(2 pi i j / k), 0 < j < k / 2) / k: eigenvalues 1 and 2^(-j) twice, so the subdominant ones
    /// are 1/2 for every k. The form follows from these properties (the sum starts at 1; printed sums start at 0).
    static std::vector<double> weights(int k);
    /// Two rounds of joining midpoints: 1/2, and 1/4 for either neighbour. Subdominant (1 + cos(2 pi / k)) / 2.
    static std::vector<double> weights_simplest(int k);
};

/// One step of each. Boundary: edge replication, which gives the quadratic B-spline of the boundary polygon; a crease
/// is a boundary on each side; a corner (three or more sharp edges, or a tagged vertex on a crease or boundary) stays
/// where it is, by replicating the vertex as well; tags on other vertices have no effect.
RuleStep doo_sabin_step(const RuleMesh& mesh, const RuleOptions& options);
RuleStep doo_sabin_catmull_clark_step(const RuleMesh& mesh, const RuleOptions& options);
RuleStep midedge_step(const RuleMesh& mesh, const RuleOptions& options);
RuleStep midedge_simplest_step(const RuleMesh& mesh, const RuleOptions& options);

/// Limit of a face: its centroid, with the cos / sin tangents of its corners. At a boundary: the midpoint of an edge,
/// along p_1 - p_0, across from the edge to the next row (at eigenvalue 1/4: the parametrisation stops there, the
/// surface has a tangent plane).
ClosedMasks doo_sabin_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks doo_sabin_catmull_clark_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks midedge_closed_masks(const FanShape& shape, const RuleOptions& options);
ClosedMasks midedge_simplest_closed_masks(const FanShape& shape, const RuleOptions& options);

}  // namespace tetrakis
