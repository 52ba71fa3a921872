#pragma once

#include "control_mesh.hpp"

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis {

/// Coordinates beyond it are taken for garbage: fourth powers of what is allowed, such as squares of areas, must not
/// overflow a double, and neither must their sums.
inline constexpr double k_max_coordinate = 1e60;

/// Texture coordinates beyond it would leave the floats of GLB.
inline constexpr double k_max_uv = 1e30;
inline bool is_sound_uv(const Vec2d& uv) {
    // No number compares.
    return std::abs(uv.x) <= k_max_uv && std::abs(uv.y) <= k_max_uv;
}

/// What can be wrong with control mesh data, in the order in which faults are listed.
enum class MeshFaultKind {
    array_size,            ///< arrays that do not fit together; element: 0
    no_faces,              ///< element: 0
    non_finite_vertex,     ///< element: the vertex
    absurd_coordinate,     ///< element: the vertex; beyond k_max_coordinate
    face_too_small,        ///< element: the face
    vertex_out_of_range,   ///< element: the face
    repeated_vertex,       ///< element: the face; a vertex twice in one face
    non_finite_uv,         ///< element: the texture coordinate; or beyond k_max_uv
    uv_out_of_range,       ///< element: the face
    normal_out_of_range,   ///< element: the face
    group_out_of_range,    ///< element: the face; its material or group number
    crease_tag,            ///< element: index into `creases`; sharpness negative or NaN, or no such vertex or edge
    corner_tag,            ///< element: index into `corners`; likewise
    corner_angle_tag,      ///< element: index into `corner_angles`; no such angle, corner or face, or two in a sector
    hole_tag,              ///< element: index into `holes`; no such face
    duplicate_face,        ///< element: the later face; same vertices in the same cycle
    non_manifold_edge,     ///< element: first face at it; an edge of more than two faces
    opposite_orientation,  ///< element: first face at it; two neighbours run along their edge in the same direction
    non_manifold_vertex,   ///< element: the vertex; its faces are not one fan (bow-tie)
};

/// "duplicate face", "non-manifold edge", ...
std::string_view name(MeshFaultKind kind);

struct MeshFault {
    MeshFaultKind kind;
    std::uint32_t element = 0;  ///< see MeshFaultKind; numbers start at 0
    std::uint64_t line = 0;     ///< line of the element in data.source; 0: unknown
    std::string message;        ///< what is wrong and what to do about it; numbers start at data.first_number
};

/// Everything that keeps the data from being an oriented 2-manifold with sound tags; empty when ControlMesh::build
/// would succeed. By kind, then lowest element first. How faces hang together is looked at only when each face is sound
/// by itself, and vertices only when all edges are. O(H).
std::vector<MeshFault> find_faults(const ControlMeshData& data);

/// What is odd but harmless: isolated vertices, zero-area faces, normals that are not finite, angles at vertices that
/// are no corners, faces that lie side by side and share no vertices; one sentence each. The data must be free of
/// faults.
std::vector<std::string> find_oddities(const ControlMeshData& data);

namespace detail {

struct EdgeUse;
struct MeshLinks;

/// find_faults() but for angles that contradict each other, with what it finds out on the way: all of it where there
/// are no faults. Progress of the stage "build" goes to 0.5.
std::vector<MeshFault> find_faults(const ControlMeshData& data, const RunContext& context,
                                   std::vector<EdgeUse>& sorted_uses, MeshLinks& links);
/// find_oddities() but for those of angles.
std::vector<std::string> find_oddities(const ControlMeshData& data, const MeshLinks& links);
struct DuplicateFace {
    std::uint32_t face, first;  ///< and the first face with the same vertex cycle
};
/// Faces whose vertex cycle an earlier face has already, ascending. The faces must be sound.
std::vector<DuplicateFace> duplicate_faces(const ControlMeshData& data);
/// "vertex 5 (line 9)", "face 2", ...: numbered as the source numbers them, with the line where it is known.
std::string vertex_name(const ControlMeshData& data, std::uint32_t v);
std::string face_name(const ControlMeshData& data, std::uint32_t f);

/// @throws Error invalid_input with the first few faults and their count, unless there are none
void throw_faults(const ControlMeshData& data, const std::vector<MeshFault>& faults);

}  // namespace detail
}  // namespace tetrakis
