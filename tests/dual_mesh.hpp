#pragma once

#include "random_mesh.hpp"

// Random meshes that vertex quadtrees take.
namespace tetrakis::test {

/// n-gons, boundaries with and without corners, holes, genus 0 and 1; no creases, no vertex of valence 2 inside.
inline ControlMesh random_dual_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.edge_vertices = options.crease = options.corner = 0;
    for (;; seed += 1000) {
        ControlMesh mesh = random_mesh(seed, options);
        bool valence2 = false;  // merging faces leaves some
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
            valence2 = valence2 || (!mesh.is_boundary(VertexId(v)) && mesh.face_valence(VertexId(v)) == 2);
        if (!valence2) return mesh;
    }
}

}  // namespace tetrakis::test
