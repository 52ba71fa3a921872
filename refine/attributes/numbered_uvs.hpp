#pragma once

#include "../../hier/base/vec.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrakis::detail {

struct FaceUvs {
    std::vector<Vec2d> uvs;               ///< by vertex; those of one vertex all different
    std::vector<std::uint32_t> face_uvs;  ///< per face corner
};

/// Numbers the UVs of face corners: those of one vertex that are the same, bit for bit, are one.
FaceUvs number_uvs(std::span<const std::uint32_t> face_vertices, std::span<const Vec2d> values);

}  // namespace tetrakis::detail
