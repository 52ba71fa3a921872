#pragma once

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../attributes/followed_uvs.hpp"
#include "../attributes/seam_extension.hpp"
#include "root_net.hpp"

#include <cstdint>
#include <optional>
#include <vector>

namespace tetrakis::detail {

/// An extension as a control mesh of its own: half-edges keep their numbers.
ControlMesh chart_mesh(const SeamExtension& charts);

/// The UVs of a dual scheme's faces, by arithmetic: what follow_across_seams() finds by walking.
struct CellUvs {
    std::vector<std::uint32_t> face_uvs;      ///< per face corner
    std::vector<std::uint32_t> control_face;  ///< per face, on the side whose UVs it has
};
/// @param surface, chart  roots at the corners of the faces of one level of both; the chart has more
/// @param corners         of that level
/// @param faces           of the surface, of that many segments
/// @param uvs             of the chart's points; receives those of faces that no point of the chart is made for
/// @return nothing where the chart has not all that the surface has, or a face as much of one side as of another from
///         the same corner, between which the order of its corners decides
std::optional<CellUvs> cell_uvs(const RootNet& surface, const RootNet& chart, const ChartCorners& corners,
                                std::uint32_t segments, const RootNet::Faces& faces, std::vector<Vec2d>& uvs);

}  // namespace tetrakis::detail
