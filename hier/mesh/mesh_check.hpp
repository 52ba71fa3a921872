#pragma once

#include "control_mesh.hpp"

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis {

/// A larger coordinate is an error: fourth powers of allowed values, such as squares of areas, and their sums must not
/// overflow a double.
inline constexpr double k_max_coordinate = 1e60;

/// Larger texture coordinates do not fit the floats of GLB.
inline constexpr double k_max_uv = 1e30;
inline bool is_sound_uv(const Vec2d& uv) {
    // A NaN fails these comparisons.
    return std::abs(uv.x) <= k_max_uv && std::abs(uv.y) <= k_max_uv;
}

/// Kinds of faults in control mesh data, in the order in which they are listed.
enum class MeshFaultKind {
    array_size,            ///< arrays whose sizes do not match; element: 0
    no_faces,              ///< element: 0
    non_finite_vertex,     ///< element: the vertex
    absurd_coordinate,     ///< element: the vertex; above k_max_coordinate
    face_too_small,        ///< element: the face
    vertex_out_of_range,   ///< element: the face
    repeated_vertex,       ///< element: the face; a vertex twice in one face
    non_finite_uv,         ///< element: the texture coordinate; or above k_max_uv
    uv_out_of_range,       ///< element: the face
    normal_out_of_range,   ///< element: the face
    group_out_of_range,    ///< element: the face; its material or group number
    crease_tag,            ///< element: index into `creases`; sharpness negative or NaN, or no such vertex or edge
    corner_tag,            ///< element: index into `corners`; likewise
    corner_angle_tag,      ///< element: index into `corner_angles`; no such angle, corner or face, or two in a sector
    hole_tag,              ///< element: index into `holes`; no such face
    duplicate_face,        ///< element: the later face; same vertices in the same cycle
    non_manifold_edge,     ///< element: first face at it; an edge of more than two faces
    opposite_orientation,  ///< element: first face at it; two faces use their common edge in the same direction
    non_manifold_vertex,   ///< element: the vertex; its faces are not one fan (bow-tie)
};

/// "duplicate face", "non-manifold edge", ...
std::string_view name(MeshFaultKind kind);

struct MeshFault {
    MeshFaultKind kind;
    std::uint32_t element = 0;  ///< see MeshFaultKind; numbers start at 0
    std::uint64_t line = 0;     ///< line of the element in data.source; 0: unknown
    std::string message;        ///< names the fault and the remedy; numbers start at data.first_number
};

/// All faults that keep the data from being an oriented 2-manifold with sound tags; empty if ControlMesh::build would
/// succeed. Sorted by kind, then by element. Connections of faces are checked only if each face is sound by itself, and
/// vertices only if all edges are sound. O(H).
std::vector<MeshFault> find_faults(const ControlMeshData& data);

/// Unusual but harmless properties, one sentence each: isolated vertices, zero-area faces, normals that are not finite,
/// angles at vertices that are not corners, adjacent faces that share no vertices. The data must have no faults.
std::vector<std::string> find_oddities(const ControlMeshData& data);

namespace detail {

struct EdgeUse;
struct MeshLinks;

/// find_faults() without the check for contradictory angles; it also returns the data that it computes, which is
/// complete if there are no faults. Progress of the stage "build" goes to 0.5.
std::vector<MeshFault> find_faults(const ControlMeshData& data, const RunContext& context,
                                   std::vector<EdgeUse>& sorted_uses, MeshLinks& links);
/// find_oddities() without the check of angles.
std::vector<std::string> find_oddities(const ControlMeshData& data, const MeshLinks& links);
struct DuplicateFace {
    std::uint32_t face, first;  ///< `first`: the first face with the same vertex cycle
};
/// Faces whose vertex cycle an earlier face has, ascending. The faces must be sound.
std::vector<DuplicateFace> duplicate_faces(const ControlMeshData& data);
/// "vertex 5 (line 9)", "face 2", ...: with the numbers of the source, and the line if it is known.
std::string vertex_name(const ControlMeshData& data, std::uint32_t v);
std::string face_name(const ControlMeshData& data, std::uint32_t f);

/// @throws Error invalid_input with the first few faults and their count, if there are any
void throw_faults(const ControlMeshData& data, const std::vector<MeshFault>& faults);

}  // namespace detail
}  // namespace tetrakis
