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
    /// Of each old half-edge: primal, the new half-edge that leaves the same vertex in the same direction; dual, the
    /// one in the child of the same face that leaves the corner's child.
    std::vector<int> child_halfedge{};
    /// Dual: of a sharp half-edge, the new one along the same crease or boundary. Empty otherwise.
    std::vector<int> child_crease{};
    /// Of each new face, the old one that it belongs to. Where several have a part in it, the face of an edge belongs
    /// to that of one of its half-edges, the face of a vertex to one around it.
    std::vector<int> parent_face{};
};

}  // namespace tetrakis
