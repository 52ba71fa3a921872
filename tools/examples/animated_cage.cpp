// An animated control mesh: connectivity is refined once, and each frame computes only positions and normals.
#include <tetrakis/tetrakis.hpp>

#include <cmath>
#include <iostream>
#include <vector>

int main() {
    const auto cage = tetrakis::load_control_mesh("data/head.obj");
    const tetrakis::PositionRefiner refiner(cage, "catmull-clark", 3, {.limit = true, .normals = true});
    const tetrakis::PolygonMesh& mesh = refiner.mesh();  // faces and UVs: the same for all frames

    std::vector<tetrakis::Vec3d> positions(mesh.positions.size()), normals(mesh.positions.size());
    const tetrakis::Box3d box = cage.bounding_box();
    for (int frame = 0; frame < 4; ++frame) {
        std::vector<tetrakis::Vec3d> control(cage.positions().begin(), cage.positions().end());
        for (tetrakis::Vec3d& p : control)  // sways to the side, more at the top
            p.x += 0.1 * frame * std::pow((p.y - box.lower.y) / box.diagonal(), 2);
        refiner.refine(control, positions, normals);  // the same bytes as refine() of that control mesh
        std::cout << "frame " << frame << ": " << positions.size()
                  << " vertices, from x = " << tetrakis::bounding_box(positions).lower.x << " to "
                  << tetrakis::bounding_box(positions).upper.x << '\n';
    }
}
