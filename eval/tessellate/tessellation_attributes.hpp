#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../surface/triangle_mesh.hpp"

#include <cstdint>
#include <functional>
#include <span>

namespace tetrakis {

/// Unit vertex normals of the triangles themselves, weighted by area.
void geometric_normals(TriangleMesh& mesh);

/// Gives each triangle corner its UV and merges those of one vertex that are equal, bit for bit. Reports stage
/// "attributes".
void add_uvs(TriangleMesh& mesh, const std::function<Vec2d(std::uint32_t, std::size_t)>& corner_uv,
             const RunContext& context = {});

/// Materials and groups of the control faces that the triangles come from.
void add_face_attributes(const ControlMesh& control, std::span<const std::uint32_t> triangle_face, TriangleMesh& mesh);

}  // namespace tetrakis
