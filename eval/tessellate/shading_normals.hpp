#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../surface/triangle_mesh.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// Limit normals at triangle corners 3 t + k, each from its triangle's side of a crease; zero if none is known.
using SideNormals = std::function<void(std::span<const std::uint64_t> corners, std::span<Vec3d> normals)>;

/// Gives vertices several normals if one cannot serve all triangles around: on creases, at corners and on tight
/// roundings.
/// * Infinitely sharp edges of the control mesh divide the triangles around a vertex in groups, each with the limit
///   normal of its own side.
/// * If a normal is more than `crease_degrees` off its triangle, a mean of triangle normals replaces it: of the group's
///   triangles within this angle of that triangle. So no corner's normal is farther off than this angle.
/// All other vertices keep their one normal.
/// @param mesh            one unit normal a vertex; receives `triangle_normals` and more `normals` if some are split
/// @param triangle_face   T: the control face that each triangle comes from
/// @param control         control mesh with the infinitely sharp edges; null: none
/// @param side            if empty, normals of smooth vertices nearby are continued along circular arcs instead
void split_normals(TriangleMesh& mesh, std::span<const std::uint32_t> triangle_face, const ControlMesh* control,
                   double crease_degrees, const SideNormals& side = {});

/// Unit normals at the corners of each triangle, for shading. The mesh's `triangle_normals` are used as they are; else
/// its vertex normals are split by split_normals() with the crease angle.
std::vector<std::array<Vec3f, 3>> corner_normals(TriangleMesh mesh, double crease_degrees);

/// Sets the unit vertex normals of a mesh: means of its triangles' normals, weighted by area.
void geometric_normals(TriangleMesh& mesh);

/// Unit normal of a triangle; zero if it has none.
Vec3d face_normal(const TriangleMesh& mesh, std::size_t t);

}  // namespace tetrakis::detail
