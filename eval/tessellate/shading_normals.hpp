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

/// Limit normals on the side of a crease that a triangle lies on, at corners 3 t + k; zero where none is known.
using SideNormals = std::function<void(std::span<const std::uint64_t> corners, std::span<Vec3d> normals)>;

/// Splits the normals of vertices on creases, at corners and on tight roundings, where one normal cannot serve all
/// triangles around:
/// * infinitely sharp edges of the control mesh divide the triangles around a vertex in groups, each with the limit
///   normal of its own side;
/// * a normal more than `crease_degrees` off its triangle gives way to the mean of the triangles of its group that are
///   within this angle of that triangle. So no corner's normal is farther off than that.
/// All other vertices keep their one normal.
/// @param mesh            one unit normal a vertex; receives more `normals`, and `triangle_normals`, if some are split
/// @param triangle_face   T: the control face that each triangle comes from
/// @param control         its infinitely sharp edges count. Null: none
/// @param side            may be empty: the normals of smooth vertices nearby, continued over circular arcs
void split_normals(TriangleMesh& mesh, std::span<const std::uint32_t> triangle_face, const ControlMesh* control,
                   double crease_degrees, const SideNormals& side = {});

/// Unit normals at the corners of each triangle, for shading: those of the mesh, by corner as they are; by vertex
/// where they agree with the triangle to within the crease angle, else as split_normals() has them.
std::vector<std::array<Vec3f, 3>> corner_normals(TriangleMesh mesh, double crease_degrees);

/// Gives a mesh the unit vertex normals of its triangles, weighted by area.
void geometric_normals(TriangleMesh& mesh);

/// Unit normal of a triangle; zero if it has none.
Vec3d face_normal(const TriangleMesh& mesh, std::size_t t);

}  // namespace tetrakis::detail
