#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../rules/polygon_mesh.hpp"
#include "../rules/refine_options.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// How the points of a refined mesh come from control points: the way that its refinement has taken, with all it knows
/// of connectivity and tags.
struct RefinedPoints {
    std::uint32_t count = 0;  ///< with those that no face uses
    /// Control points to that many points, and to as many normals where there is room for any. On the threads that it
    /// is called on.
    std::function<void(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals)> refine{};
    /// The points that are vertices of the mesh, in their order; empty where all are.
    std::vector<std::uint32_t> used{};

    /// All of them for the control mesh as it is, with their attributes.
    void make(const ControlMesh& mesh, const RefineOptions& options, PolygonMesh& result) const;
};

/// Takes the vertices that no face has out of the mesh; notes which are left, unless `points` is null.
void drop_unused_points(PolygonMesh& mesh, RefinedPoints* points);

/// refine() as it is, and what gives the points again, unless that is null. It refers to the control mesh.
PolygonMesh refine_with_points(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                               const RefineOptions& options, RefinedPoints* points);

}  // namespace tetrakis::detail
