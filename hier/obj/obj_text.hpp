#pragma once

#include "../base/run_context.hpp"
#include "../mesh/control_mesh.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace tetrakis::detail {

enum class ObjUse {
    control_mesh,  ///< tags are read; numbers that are not finite are left to find_faults(), which repair() can mend
    triangles,     ///< tags are passed over; numbers that are not finite are refused
};

/// In `face_uvs` and `face_normals`: a corner has none; it names one that no number can.
inline constexpr std::uint32_t k_obj_absent = 0xFFFF'FFFFu, k_obj_no_such = 0xFFFF'FFFEu;

/// What an OBJ text says: positions, texture coordinates and normals (correctly rounded), faces, groups, materials,
/// tags, line numbers, warnings of what is left out. Corners whose vertex no number can name have VertexId::none;
/// a layer of corners is empty where none has it. O(length).
///
/// OpenSubdiv's tag lines are `t NAME ints/reals/strings  ints...  reals...  strings...`, with vertices and faces
/// counted from 0. Creases are pairs of vertices (as OpenSubdiv's own examples read them) with one sharpness for all,
/// one for each pair, or one for each vertex of which the first of a pair counts. One of our own,
/// `t cornerangle N/M/0 vertex face ... degrees ...`: ControlMeshData::corner_angles, one angle for all or one for each
/// pair.
/// @param source  file name for messages
/// @throws Error  invalid_input with the line and advice: a malformed line, bytes that are no text. The caller refuses
///                indices that are out of range
ControlMeshData read_obj_text(std::string_view text, std::string source, ObjUse use, const RunContext& context = {});

}  // namespace tetrakis::detail
