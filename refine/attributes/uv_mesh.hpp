#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis {

/// The UV layer as a control mesh: the same faces and half-edge numbers, but cut open along UV seams; its positions are
/// (u, v, 0). Refining it as a surface refines the UVs. An edge is a seam if the UV numbers of its two sides differ.
/// Seams become boundaries; creases away from seams and all corners of the mesh are copied. Where the face-varying rule
/// fixes UVs, the vertex is a corner. A UV of a vertex at which several charts, or parts of one, touch is fixed, too,
/// as in OpenSubdiv. The rule linear_all is not in the mesh: the caller interpolates linearly instead. Corner angles
/// are those of the mesh, measured ones included; if seams cut a sector, each part has its share.
/// @param mesh   must have UVs
/// @param rules  rules of the mesh; refine the result by chart_rules()
ControlMesh uv_mesh(const ControlMesh& mesh, const RuleOptions& rules = {});

namespace detail {

struct FaceUvs {
    std::vector<Vec2d> uvs;               ///< UVs by vertex; all UVs of one vertex differ
    std::vector<std::uint32_t> face_uvs;  ///< per face corner: its number in `uvs`
};

/// Numbers the UVs of face corners. UVs of one vertex that are equal, bit for bit, get one number.
FaceUvs number_uvs(std::span<const std::uint32_t> face_vertices, std::span<const Vec2d> values);

/// The rules for refining uv_mesh(): angles that the mesh measures have been measured already.
RuleOptions chart_rules(RuleOptions rules);
/// If the mesh has tags for which the scheme has no rule: the mesh without its interior creases and corners. So UVs
/// ignore the tags that positions ignore.
std::optional<ControlMesh> without_ignored_tags(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                const RuleOptions& rules);

}  // namespace detail

}  // namespace tetrakis
