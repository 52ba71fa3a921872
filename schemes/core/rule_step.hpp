#pragma once

#include "rule_mesh.hpp"
#include "rule_options.hpp"
#include "stencil_table.hpp"

#include <vector>

namespace tetrakis {

/// One step of a scheme: the finer mesh, and each of its points as a combination of the coarser ones.
///
/// Primal schemes keep the numbers of old vertices; a dual scheme's first points are the children of the half-edges
/// (of the corner at the half-edge's origin).
struct RuleStep {
    RuleMesh mesh;
    StencilTable stencils;
    /// Per old half-edge. Primal: the new half-edge that leaves the same vertex in the same direction. Dual: the one in
    /// the child of the same face that leaves the corner's child.
    std::vector<int> child_halfedge{};
    /// Dual: per sharp half-edge, the new one along the same crease or boundary. Empty for other schemes.
    std::vector<int> child_crease{};
    /// Per new face, the old face that it is assigned to. A face made of an edge is assigned to the face of one of its
    /// half-edges, a face made of a vertex to a face around it.
    std::vector<int> parent_face{};
};

}  // namespace tetrakis
