#pragma once

#include "tetrakis/eval/triangle_mesh.hpp"
#include "tetrakis/hier/vec.hpp"

#include <array>
#include <vector>

namespace tetrakis::detail {

/// Unit normals at the corners of each triangle, for shading. Those of the mesh, where they agree with the triangle to
/// within the crease angle; else the mean of the triangles around the vertex that do, weighted by their angles. So a
/// sharp edge stays sharp although its vertices have one normal each.
std::vector<std::array<Vec3f, 3>> corner_normals(const TriangleMesh& mesh, double crease_degrees);

/// Unit normal of a triangle; zero if it has none.
Vec3d face_normal(const TriangleMesh& mesh, std::size_t t);

}  // namespace tetrakis::detail
