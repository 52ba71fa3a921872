#include "tetrakis/eval/closest_bvh.hpp"
#include "tetrakis/hier/control_mesh.hpp"
#include "tetrakis/hier/version.hpp"

#include <cmath>
#include <iostream>
#include <vector>

// Uses one call of each library that has compiled code, so that a missing symbol, header or dependency shows.
int main() {
    tetrakis::ControlMeshData data;
    for (int i = 0; i < 8; ++i) data.positions.push_back({i & 1, i >> 1 & 1, i >> 2 & 1});
    data.face_vertices = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5};
    data.face_offsets = {0, 4, 8, 12, 16, 20, 24};
    const auto mesh = tetrakis::ControlMesh::build(std::move(data));

    std::vector<tetrakis::Box3d> boxes(mesh.vertex_count());
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) boxes[v].add(mesh.position(tetrakis::VertexId(v)));
    const tetrakis::ClosestBvh nearest(boxes);

    std::cout << "tetrakis " << tetrakis::k_version << ": a cube of " << mesh.edge_count() << " edges\n";
    return mesh.edge_count() == 12 && nearest.size() == 8 && TETRAKIS_VERSION_NUMBER >= 100 ? 0 : 1;
}
