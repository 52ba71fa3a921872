#pragma once

#include "control_mesh.hpp"
#include "mesh_check.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::detail {

/// What the tags of ControlMeshData::corner_angles say.
struct TaggedAngles {
    std::vector<double> angle;        ///< H: see ControlMesh::corner_angle(); empty: no corner has one
    std::vector<MeshFault> faults;    ///< tags whose sector has another angle from an earlier one (`a`)
    std::vector<std::uint32_t> idle;  ///< tags at vertices that are no corners, ascending
};

/// @param mesh  made of the data, with or without these tags
TaggedAngles tagged_angles(const ControlMesh& mesh, const ControlMeshData& data);
/// A warning of those that have no effect, if there are any.
std::optional<std::string> idle_angles(const ControlMeshData& data, const TaggedAngles& angles);

/// Whether a tag may have this angle.
bool is_sector_angle(double radians);
/// For messages: a tag's vertex or face as its file has it, where a mesh can have that; a tag by its number.
std::string tag_number(std::uint32_t n);
std::string angle_tag_name(const ControlMeshData& data, std::uint32_t i);
inline constexpr std::string_view k_drop_tag = "or use --repair to drop the tag";
std::string degrees(double radians);
/// The half-edge of a face that leaves a vertex; none where the face does not touch it.
std::uint32_t face_corner(const ControlMeshData& data, std::uint32_t face, std::uint32_t vertex);

}  // namespace tetrakis::detail
