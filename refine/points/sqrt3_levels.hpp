#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "level_source.hpp"

#include <memory>

namespace tetrakis {

/// The sqrt(3) scheme's points over sites of control triangles (sqrt3_site()). Levels are simple steps, two of which
/// are one level of refine(). Even levels and limits are those of detail::row_points(), odd levels are one simple step
/// from the even ones. Keeps references to the mesh and the scheme.
/// @param mesh  of triangles
/// @param context, whole_levels  as row_points() takes them
std::shared_ptr<const LevelSource> sqrt3_levels(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                const RuleOptions& rules, const RunContext& context, bool whole_levels);

}  // namespace tetrakis
