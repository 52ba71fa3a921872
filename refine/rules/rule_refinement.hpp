#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "polygon_mesh.hpp"
#include "rule_refiner.hpp"

namespace tetrakis {

/// The control mesh refined by any scheme of the table with RuleRefiner, as a mesh: points and faces only, holes and
/// isolated vertices among them. For UVs, groups and speed see refine().
/// @throws Error  as RuleRefiner
PolygonMesh refine_by_rules(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                            const RuleOptions& options = {});

}  // namespace tetrakis
