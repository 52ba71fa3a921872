#pragma once

#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/refine/polygon_mesh.hpp"
#include "tetrakis/schemes/scheme_table.hpp"

namespace tetrakis {

/// The control mesh as the rules of any scheme take it, same numbers of vertices, half-edges and faces.
RuleMesh rule_mesh(const ControlMesh& mesh);

/// The control mesh refined by any scheme of the table, by its rules, point by point: the general path, for every
/// scheme, choice and kind of mesh. Catmull-Clark and Loop have a much faster one, refine_uniform(). Holes are refined
/// like other faces; positions only.
/// @param levels  >= 0: steps of the scheme (a sqrt3 or 4-8 step is two of its binary steps)
/// @throws Error  invalid_input: levels < 0, or a mesh that the scheme cannot take (the message says why); unsupported:
///                more elements than 31 bits can count
/// Cost: about a microsecond per point and level, one thread.
PolygonMesh refine_by_rules(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                            const RuleOptions& options = {});

}  // namespace tetrakis
