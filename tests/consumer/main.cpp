#include <tetrakis/tetrakis.hpp>

#include <iostream>
#include <utility>

// Calls what joins all layers, so that a missing symbol, header or dependency of any of them shows.
int main() {
    tetrakis::ControlMeshData data;
    for (int i = 0; i < 8; ++i) data.positions.push_back({i & 1, i >> 1 & 1, i >> 2 & 1});
    data.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    data.face_offsets = {0, 4, 8, 12, 16, 20, 24};
    const auto mesh = tetrakis::ControlMesh::build(std::move(data));

    tetrakis::TessellateOptions options;
    options.tolerance = 0.01;
    const auto result = tetrakis::tessellate(mesh, options);

    std::cout << "tetrakis " << tetrakis::k_version << ": a cube's limit surface in " << result.mesh.triangles.size()
              << " triangles\n";
    return result.tolerance_reached && result.mesh.triangles.size() > 12 && TETRAKIS_VERSION_NUMBER >= 100 ? 0 : 1;
}
