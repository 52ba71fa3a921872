#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../rules/polygon_mesh.hpp"
#include "../rules/rule_refiner.hpp"
#include "seam_extension.hpp"
#include "uv_mesh.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// UVs for schemes whose refined charts have other faces than the refined mesh: one entry per face corner, in the order
/// of the last level's half-edges.
struct FollowedUvs : FaceUvs {  // no numbers: the charts could not be followed
    /// Per face, the control face of most of its corners on the side whose UVs it has. Empty: as without UVs.
    std::vector<std::uint32_t> control_face;
};

/// Whether a scheme that splits faces has no boundary rule of its own: longer averages use copies of the boundary, and
/// receding ones use it up. A seam as a boundary would pull the chart together, so the chart is extended across it.
bool extends_charts(const SchemeInfo& scheme, const RuleOptions& rules);

/// Refines the mesh and its charts side by side; each corner inside a chart has a partner in the charts.
///
/// Dual schemes and honeycomb: charts are extended (SeamExtension). A face across a seam takes the UVs of one side: the
/// side with most of its corners, else the one with the lower control face, else (dual) with the lower corner of level
/// 1. Its other corners get UVs of the extension. So the visible seam is within half a face of the true one. If
/// extends_charts(), the charts have all faces of the mesh.
///
/// sqrt3: the charts (linear, or with seams as boundaries by the scheme's rules) have the same triangles as the mesh,
/// in another order.
FollowedUvs follow_uvs(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RuleOptions& rules);

}  // namespace tetrakis::detail
