#pragma once

#include "../base/run_context.hpp"
#include "../mesh/control_mesh.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace tetrakis::detail {

enum class ObjUse {
    control_mesh,  ///< tags are read; numbers that are not finite are left to find_faults() and repair()
    triangles,     ///< tags are skipped; numbers that are not finite are errors
};

/// Values in `face_uvs` and `face_normals`: the corner has none; its number is impossible.
inline constexpr std::uint32_t k_obj_absent = 0xFFFF'FFFFu, k_obj_no_such = 0xFFFF'FFFEu;

/// The data of an OBJ text: positions, texture coordinates and normals (correctly rounded), faces, groups, materials,
/// tags, line numbers, and warnings about ignored lines. Corners with an impossible vertex number have
/// VertexId::none; a layer of corners is empty if no corner has it. O(length).
///
/// OpenSubdiv's tag lines are `t NAME ints/reals/strings  ints...  reals...  strings...`; vertices and faces are
/// counted from 0. Creases are pairs of vertices (as in OpenSubdiv's own examples). They have one sharpness for all,
/// one for each pair, or one for each vertex, of which the first of a pair counts. The tag `t cornerangle N/M/0 vertex
/// face ... degrees ...` is our own: ControlMeshData::corner_angles, one angle for all pairs or one for each.
/// @param source  file name for messages
/// @throws Error  invalid_input, with the line and advice: a malformed line, or bytes that are no text. The caller must
///                check indices for being out of range
ControlMeshData read_obj_text(std::string_view text, std::string source, ObjUse use, const RunContext& context = {});

}  // namespace tetrakis::detail
