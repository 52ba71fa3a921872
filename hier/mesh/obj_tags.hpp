#pragma once

#include "control_mesh.hpp"
#include "obj_lines.hpp"

#include <cstdint>
#include <string_view>

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

}  // namespace tetrakis::detail
