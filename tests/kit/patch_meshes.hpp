#pragma once

#include "quad_test_mesh.hpp"
#include "triangle_test_mesh.hpp"

#include "../../eval/distance/surface_family.hpp"

#include <type_traits>

namespace tetrakis::test {

/// Random meshes with tags of all kinds, by both crease methods, of the faces that the family of patches takes.
template <class Family>
ControlMesh random_patch_mesh(std::uint64_t seed) {
    if constexpr (std::is_same_v<Family, LoopFamily>)
        return random_tagged_mesh(static_cast<std::uint32_t>(seed));
    else
        return random_quad_mesh(seed / 2, seed % 2 == 1 ? CreaseMethod::chaikin : CreaseMethod::uniform);
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
