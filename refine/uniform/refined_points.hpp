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

/// Computes the points of a refined mesh from control points in the way that its refinement has taken. No work on
/// connectivity and tags is done again.
struct RefinedPoints {
    std::uint32_t count = 0;  ///< number of points, including those that no face uses
    /// Computes `count` points and, unless `normals` is empty, as many normals, on the threads that the caller has set.
    std::function<void(std::span<const Vec3d> control, std::span<Vec3d> points, std::span<Vec3d> normals)> refine{};
    /// For each vertex of the mesh, the number of its point; empty: vertices and points are the same.
    std::vector<std::uint32_t> used{};

    /// Writes all points into `result`, with normals and attributes, for the positions of the control mesh.
    void make(const ControlMesh& mesh, const RefineOptions& options, PolygonMesh& result) const;
};

/// Removes the vertices that no face uses from the mesh; records the others in RefinedPoints::used unless it is null.
void drop_unused_points(PolygonMesh& mesh, RefinedPoints* points);

/// refine(), but faces are not cut into triangles. Unless `points` is null, it receives the way to compute the points
/// again, which refers to the control mesh.
PolygonMesh refine_with_points(const ControlMesh& mesh, const SchemeInfo& scheme, int levels,
                               const RefineOptions& options, RefinedPoints* points);

}  // namespace tetrakis::detail
