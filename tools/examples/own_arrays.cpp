// From your own arrays to buffers for a graphics card: a cube with UVs and a sharp rim around its top face.
#include <tetrakis/tetrakis.hpp>

#include <iostream>
#include <utility>

int main() {
    tetrakis::ControlMeshData data;
    for (int i = 0; i < 8; ++i) data.positions.push_back({i & 1, i >> 1 & 1, i >> 2 & 1});
    // Faces of any size, one after the other, counter-clockwise seen from outside.
    data.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    data.face_offsets = {0, 4, 8, 12, 16, 20, 24};
    // A sharpness from 0 (smooth) to 10 (infinitely sharp) for edges; data.corners has the same for vertices.
    constexpr float sharp = tetrakis::k_infinite_sharpness;
    data.creases = {{4, 5, sharp}, {5, 7, sharp}, {7, 6, sharp}, {6, 4, sharp}};
    // UVs have their own indices. Here each face shows the whole picture.
    data.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int face = 0; face < 6; ++face) data.face_uvs.insert(data.face_uvs.end(), {0, 1, 2, 3});

    const auto cage = tetrakis::ControlMesh::build(std::move(data));
    const auto result = tetrakis::tessellate(cage, {.tolerance = 1e-2});
    // On seams and sharp edges a vertex has several UVs or normals; the buffers then contain a copy for each.
    const tetrakis::GpuMesh gpu = tetrakis::gpu_mesh(result.mesh);

    std::cout << result.mesh.positions.size() << " vertices, " << gpu.positions.size() << " in the buffers, "
              << gpu.indices.size() / 3 << " triangles\n";
    std::cout << "bytes to upload: positions " << gpu.positions.size() * sizeof(gpu.positions[0]) << ", normals "
              << gpu.normals.size() * sizeof(gpu.normals[0]) << ", UVs " << gpu.uvs.size() * sizeof(gpu.uvs[0])
              << ", indices " << gpu.indices.size() * sizeof(gpu.indices[0]) << '\n';
    return gpu.uvs.size() == gpu.positions.size() && gpu.normals.size() == gpu.positions.size() ? 0 : 1;
}
