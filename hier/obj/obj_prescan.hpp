#pragma once

#include "../mesh/control_mesh.hpp"
#include "obj_lines.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tetrakis::detail {

/// Reads one of OpenSubdiv's tag lines into the data: `t NAME ints/reals/strings  ints...  reals...  strings...`, with
/// vertices and faces counted from 0. Creases are pairs of vertices (as OpenSubdiv's own examples read them) with one
/// sharpness for all, one for each pair, or one for each vertex of which the first of a pair counts.
/// One of our own, `t cornerangle N/M/0 vertex face ... degrees ...`: ControlMeshData::corner_angles, one angle for all
/// or one for each pair.
/// @param words  what follows the `t`
/// @return       false for a tag of another name, which is left alone
/// @throws Error invalid_input: the line does not say what its tag needs
bool read_obj_tag(ObjWords words, std::uint64_t line, ControlMeshData& data);

/// What our own pass over an OBJ text finds. It checks every word of every line that matters, so that tinyobjloader
/// (which reads nan as 0, fills in what is missing and knows no line numbers) is only shown lines that it gets right.
struct ObjScan {
    /// Positions (correctly rounded; tinyobjloader adds up decimals with rounding errors), groups, materials, tags,
    /// line numbers, source; not: what is read from `normalised`.
    ControlMeshData data;
    std::vector<std::uint32_t> face_sizes;  ///< corners of each face as written, 0 and 300 included
    /// Lines `vt`, `vn` and `f` for tinyobjloader: continuations joined, indices positive (0: absent; k_no_element: no
    /// such element), numbers plain.
    std::string normalised;
    std::vector<std::pair<std::uint32_t, Vec2d>> uvs;      ///< texture coordinates that replace those read
    std::vector<std::pair<std::uint32_t, Vec3d>> normals;  ///< normals likewise
    std::uint32_t uv_count = 0, normal_count = 0;

    /// Index in `normalised` for what is not there: the largest that tinyobjloader's int holds.
    static constexpr std::int64_t k_no_element = 0x7FFF'FFFF;
};

/// One pass, O(length).
/// @param source  file name for messages
/// @throws Error  invalid_input with the line and advice: a malformed line, bytes that are no text. Numbers that are
///                not finite and indices out of range are left to find_faults(), which repair() can mend.
ObjScan prescan_obj(std::string_view text, std::string source);

}  // namespace tetrakis::detail
