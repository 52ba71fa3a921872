#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../rules/limit_point.hpp"

namespace tetrakis::detail {

/// LevelSource::frames() of the control mesh at its vertices.
LimitPoint control_frame(const ControlMesh& mesh, VertexId v);

/// A frame from a position, a sum of normals by area and a direction from the position to a neighbour.
LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards);

}  // namespace tetrakis::detail
