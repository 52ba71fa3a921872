#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <vector>

namespace tetrakis::detail {

/// The UV layer, cut along its seams (see uv_mesh()), with rows of quads beyond them that continue each chart straight:
/// beside a seam, schemes whose new faces lie across it then take their smooth rules. Half-edge h of the control mesh
/// is half-edge h of `mesh`; the quads beyond come after.
///
/// Beyond a vertex of a seam goes its mirror image of the mean of its neighbours inside the chart, or, at the end of a
/// seam in the mesh's boundary, of the neighbour along that boundary. The corner of a chart (one face) gets a quad of
/// its own, as on a grid: mirror images of either neighbour, and of their sum.
struct SeamExtension {
    RuleMesh mesh;
    std::vector<Vec2d> uvs;  ///< of its vertices
};

/// As the scheme's rules need it, for dual schemes, honeycomb, and where extends_charts(): along seams, but those of
/// boundaries and of creases that stay.
/// @param mesh     must have UVs
/// @param surface  rule_mesh(mesh)
SeamExtension extend_over_seams(const ControlMesh& mesh, const RuleMesh& surface, const SchemeInfo& scheme,
                                const RuleOptions& rules);

}  // namespace tetrakis::detail
