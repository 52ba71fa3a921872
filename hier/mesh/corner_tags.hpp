#pragma once

#include "control_mesh.hpp"
#include "mesh_check.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::detail {

/// The meaning of the tags in ControlMeshData::corner_angles.
struct TaggedAngles {
    std::vector<double> angle;        ///< H: see ControlMesh::corner_angle(); empty: no corner has one
    std::vector<MeshFault> faults;    ///< tags that give a sector another angle than an earlier tag (`a`)
    std::vector<std::uint32_t> idle;  ///< tags at vertices that are not corners, ascending
};

/// @param mesh  built from the data, with or without these tags
TaggedAngles tagged_angles(const ControlMesh& mesh, const ControlMeshData& data);
/// A warning about tags that have no effect, if there are any.
std::optional<std::string> idle_angles(const ControlMeshData& data, const TaggedAngles& angles);

/// Whether a tag may have this angle.
bool is_sector_angle(double radians);
/// For messages: a vertex or face number of a tag as in its file, if it is possible in a mesh; a tag by its number.
std::string tag_number(std::uint32_t n);
std::string angle_tag_name(const ControlMeshData& data, std::uint32_t i);
inline constexpr std::string_view k_drop_tag = "or use --repair to drop the tag";
std::string degrees(double radians);
/// The half-edge of a face that starts at a vertex; none if the face does not have the vertex.
std::uint32_t face_corner(const ControlMeshData& data, std::uint32_t face, std::uint32_t vertex);

}  // namespace tetrakis::detail
