#pragma once

#include "random_mesh.hpp"

namespace tetrakis::test {

/// random_mesh() with a crease method; every third one full of creases, so that whole chains of them meet.
inline ControlMesh random_quad_mesh(std::uint64_t seed, CreaseMethod method) {
    RandomMeshOptions options = random_options(seed);
    if (seed % 3 == 0) options.crease = 0.5;
    if (seed % 4 == 1) options.split = options.merge = 0;
    ControlMeshData data = random_mesh_data(seed, options);
    data.crease_method = method;
    return ControlMesh::build(std::move(data));
}

}  // namespace tetrakis::test
