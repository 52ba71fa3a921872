#pragma once

#include "random_mesh.hpp"

// Random meshes that vertex quadtrees take.
namespace tetrakis::test {

enum class DualTags { infinitely_sharp, of_all_kinds };

/// n-gons, boundaries with and without corners, holes, genus 0 and 1. Creases and corners as the options say:
/// infinitely sharp, or half of them and the others up to 4. Of seed, seed + 1000, ... the first one that has no vertex
/// of two faces inside.
inline ControlMesh random_dual_mesh(std::uint64_t seed, RandomMeshOptions options,
                                    DualTags tags = DualTags::infinitely_sharp) {
    options.edge_vertices = 0;
    for (;; seed += 1000) {
        ControlMeshData data = random_mesh_data(seed, options);
        if (tags == DualTags::infinitely_sharp) {
            for (auto& crease : data.creases) crease.sharpness = k_infinite_sharpness;
            for (auto& corner : data.corners) corner.sharpness = k_infinite_sharpness;
        }
        ControlMesh mesh = ControlMesh::build(std::move(data));
        bool valence2 = false;  // merging faces leaves some
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            valence2 = valence2 || (!mesh.is_boundary(VertexId(v)) && mesh.face_valence(VertexId(v)) == 2);
        if (!valence2) return mesh;
    }
}
/// Without creases inside and tagged corners.
inline ControlMesh random_dual_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.crease = options.corner = 0;
    return random_dual_mesh(seed, options);
}
/// Creases that end at boundaries and inside, cross and close; corners on them and elsewhere.
inline ControlMesh random_creased_dual_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.crease = 0.25;
    options.corner = 0.1;
    return random_dual_mesh(seed, options);
}

}  // namespace tetrakis::test
