#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../schemes/core/rule_options.hpp"
#include "polygon_mesh.hpp"

#include <span>

namespace tetrakis {

struct RefineOptions {
    RuleOptions rules{};
    /// Rounds of smoothing of the control points before the first level, for interpolating schemes, which show every
    /// dent of the control mesh: each point goes halfway to the mean of its neighbours (on a crease or boundary of its
    /// two along it; corners stay).
    int smoothing = 0;
    bool limit = false;    ///< put the vertices on the limit surface
    bool normals = false;  ///< limit normals (with or without `limit`)
    /// refine() only: numbers per control vertex, refined by the same masks into PolygonMesh::attributes.
    std::span<const VertexAttribute> attributes{};
    RunContext context{};
};

}  // namespace tetrakis
