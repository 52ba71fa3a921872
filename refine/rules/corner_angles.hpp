#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <vector>

namespace tetrakis::detail {

/// The angles that RuleMesh::corner_angle() gives: from the tags of the control mesh and, if `rules` ask for it,
/// measured in the other sectors at its corners. Empty if no corner has an angle.
std::vector<double> corner_angles(const ControlMesh& mesh, const RuleOptions& rules);

/// For code that knows only the plain rules of Catmull-Clark and Loop, which ignore corner angles.
/// @throws Error unsupported: the mesh has corner angles
void refuse_corner_angles(const ControlMesh& mesh);

}  // namespace tetrakis::detail
