#pragma once

#include "../../hier/base/run_context.hpp"
#include "../../schemes/core/rule_options.hpp"
#include "polygon_mesh.hpp"

#include <span>

namespace tetrakis {

struct RefineOptions {
    RuleOptions rules{};
    /// Rounds of smoothing of the control points before the first level. Interpolating schemes show every dent of the
    /// control mesh without it. A round moves each point halfway to the mean of its neighbours; on a crease or
    /// boundary, of the two neighbours along it. Corners stay.
    int smoothing = 0;
    bool limit = false;    ///< put the vertices on the limit surface
    bool normals = false;  ///< limit normals (with or without `limit`)
    /// For refine() only: values at the control vertices, refined by the same masks into PolygonMesh::attributes.
    std::span<const VertexAttribute> attributes{};
    RunContext context{};
};

}  // namespace tetrakis
