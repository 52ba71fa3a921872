#pragma once

#include "../../eval/surface/triangle_mesh.hpp"
#include "../../refine/rules/polygon_mesh.hpp"

#include <cstdint>

// Control meshes, as OBJ, on which any scheme can be tried, and what it makes of them as triangles.
namespace tetrakis::test {

/// A cube with a roof on one side: vertices with three, four and five edges.
inline constexpr const char* k_closed =
    "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\nv 0.2 0 1.7\n"
    "f 1 3 4 2\nf 1 2 6 5\nf 4 3 7 8\nf 3 1 5 7\nf 2 4 8 6\nf 5 6 9\nf 6 8 9\nf 8 7 9\nf 7 5 9\n";

/// A tube of quads, wider in the middle: a boundary without corners.
inline constexpr const char* k_tube =
    "v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 1.3 0 1\nv 0 1.3 1\nv -1.3 0 1\nv 0 -1.3 1\nv 0.8 0 2\nv 0 0.8 2\n"
    "v -0.8 0 2\nv 0 -0.8 2\n"
    "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n";

/// Faces cut into fans.
inline TriangleMesh triangles_of(const PolygonMesh& mesh) {
    TriangleMesh result;
    result.positions = mesh.positions;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        for (std::uint32_t i = mesh.face_offsets[f] + 1; i + 1 < mesh.face_offsets[f + 1]; ++i)
            result.triangles.push_back(
                {mesh.face_vertices[mesh.face_offsets[f]], mesh.face_vertices[i], mesh.face_vertices[i + 1]});
    return result;
}

}  // namespace tetrakis::test
