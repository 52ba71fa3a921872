#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../rules/polygon_mesh.hpp"

#include <functional>
#include <span>
#include <vector>

namespace tetrakis::detail {

/// @throws Error  invalid_input: a width below one, or not `width` values for each control vertex (names the attribute)
void check_attributes(const ControlMesh& mesh, std::span<const VertexAttribute> attributes);

/// Attributes as points go through `refine`, three numbers at a time; what is left of the last three is zero.
/// @param refine  control points to the points of `vertex_count` refined vertices
std::vector<VertexAttribute> refine_by_threes(
    std::span<const VertexAttribute> attributes, std::uint32_t control_count, std::uint32_t vertex_count,
    const std::function<void(std::span<const Vec3d>, std::span<Vec3d>)>& refine);

}  // namespace tetrakis::detail
