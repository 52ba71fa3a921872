#pragma once

#include "random_mesh.hpp"

#include "../../eval/distance/surface_family.hpp"

#include <algorithm>
#include <type_traits>

namespace tetrakis::test {

/// Small random meshes with tags of all kinds, of the faces that the family of patches takes: each by both crease
/// methods, every third full of creases, so that whole chains of them meet.
template <class Family>
ControlMesh random_patch_mesh(std::uint64_t seed) {
    const std::uint64_t mesh = seed / 2;
    RandomMeshOptions options = random_options(mesh);
    options.columns = std::min(options.columns, 4);
    options.rows = std::min(options.rows, 4);
    options.triangles_only = std::is_same_v<Family, LoopFamily>;
    if (mesh % 3 == 0) options.crease = 0.5;
    if (mesh % 4 == 1) options.split = options.merge = 0;
    ControlMeshData data = random_mesh_data(mesh, options);
    data.crease_method = seed % 2 == 1 ? CreaseMethod::chaikin : CreaseMethod::uniform;
    return ControlMesh::build(std::move(data));
}

/// One half-edge for each root of the surface: of each face of triangles, of each corner of other faces.
template <class Family>
std::vector<HalfedgeId> roots_of(const ControlMesh& mesh) {
    std::vector<HalfedgeId> roots;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        const FaceId face = mesh.face(HalfedgeId(h));
        if (std::is_same_v<Family, LoopFamily> && mesh.face_halfedge(face).value != h) continue;
        if (!mesh.is_hole(face)) roots.push_back(HalfedgeId(h));
    }
    return roots;
}

}  // namespace tetrakis::test
