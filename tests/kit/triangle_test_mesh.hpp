#pragma once

#include "random_mesh.hpp"

namespace tetrakis::test {

/// random_mesh() with triangles only, and up to a third of its faces taken out (where the rest stays a manifold).
inline ControlMesh random_triangle_mesh(std::uint64_t seed) {
    RandomMeshOptions options = random_options(seed);
    options.triangles_only = true;
    if (seed % 3 != 0) options.removed_faces = static_cast<int>(Random(seed).below(20));
    return random_mesh(seed, options);
}

}  // namespace tetrakis::test
