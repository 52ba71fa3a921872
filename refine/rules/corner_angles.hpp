#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <vector>

namespace tetrakis::detail {

/// RuleMesh::corner_angle() of a control mesh: of its tags, and where the rules measure them of all other sectors at
/// its corners. Empty: no corner has one.
std::vector<double> corner_angles(const ControlMesh& mesh, const RuleOptions& rules);

/// For what knows the plain rules of Catmull-Clark and Loop alone.
/// @throws Error unsupported: the mesh has corner angles
void refuse_corner_angles(const ControlMesh& mesh);

}  // namespace tetrakis::detail
