#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/rule_step.hpp"
#include "../../schemes/core/scheme_table.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrakis {

/// The UV layer as a control mesh of its own: same faces, so the same half-edge numbers, but cut open along UV seams;
/// its positions are (u, v, 0). Refining it as a surface refines the UVs: an edge is a seam where the UV numbers of its
/// two sides differ, seams are boundaries, and creases off the seams and all corners of the mesh carry over.
/// What the face-varying rule keeps is a corner of it; where several charts, or parts of one, touch in a single UV of a
/// vertex, it stays, as in OpenSubdiv; linear_all is not in the mesh: its caller interpolates linearly instead.
/// Its corners have the angles of the mesh's, measured ones included; of a sector that seams cut each part has its
/// share.
/// @param mesh   must have UVs
/// @param rules  of the mesh; those of the charts are chart_rules()
ControlMesh uv_mesh(const ControlMesh& mesh, const RuleOptions& rules = {});

namespace detail {

struct FaceUvs {
    std::vector<Vec2d> uvs;               ///< by vertex; those of one vertex all different
    std::vector<std::uint32_t> face_uvs;  ///< per face corner
};

/// Numbers the UVs of face corners: those of one vertex that are the same, bit for bit, are one.
FaceUvs number_uvs(std::span<const std::uint32_t> face_vertices, std::span<const Vec2d> values);

/// By which uv_mesh() is refined: what the mesh measures has been measured.
RuleOptions chart_rules(RuleOptions rules);
/// The mesh without creases and corners inside, where it has tags and the scheme has no rule for these: so UVs ignore
/// what positions do.
std::optional<ControlMesh> without_ignored_tags(const ControlMesh& mesh, const SchemeInfo& scheme,
                                                const RuleOptions& rules);

}  // namespace detail

}  // namespace tetrakis
