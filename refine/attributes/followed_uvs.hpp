#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../rules/polygon_mesh.hpp"
#include "../rules/rule_refiner.hpp"
#include "seam_extension.hpp"
#include "uv_mesh.hpp"

#include <cstdint>
#include <vector>

namespace tetrakis::detail {

/// UVs where the faces of the refined mesh are not those of the refined charts: one entry per face corner, in the order
/// of the last level's half-edges.
struct FollowedUvs : FaceUvs {  // without numbers: the charts could not be followed
    /// Per face, the control face that it lies in, or the most of it on the side whose UVs it has; empty: as ever.
    std::vector<std::uint32_t> control_face;
};

/// Whether a scheme that splits faces has no rule for boundaries: the longer averages take copies of them, those that
/// recede use them up. A seam would then pull the chart together, so there it is continued, too.
bool extends_charts(const SchemeInfo& scheme, const RuleOptions& rules);

/// The mesh and its charts are refined side by side; each corner inside a chart has its partner there.
///
/// Dual schemes and honeycomb: charts are extended (SeamExtension). A face across a seam takes the UVs of one side, the
/// one with the most of its corners, then the one of the lower control face, then (dual) that of the lower corner of
/// level 1; beyond the seam those of the extension. So the seam that is seen is the true one to half a face. Where
/// extends_charts(), the charts have all faces of the mesh.
///
/// sqrt3: charts (with seams as boundaries, by the scheme's rules; or linear) have the same triangles as the mesh in
/// another order.
FollowedUvs follow_uvs(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RuleOptions& rules);

}  // namespace tetrakis::detail
