// Uniform levels: the refined control net, and the same vertices on the limit surface with their normals.
#include <tetrakis/tetrakis.hpp>

#include <algorithm>
#include <cstddef>
#include <iostream>

int main() {
    const auto cage = tetrakis::load_control_mesh("data/pawn.obj");
    for (int level = 0; level <= 4; ++level) {
        // Any scheme of scheme_table(). `limit` moves the vertices; faces and the order of vertices are the same.
        const auto net = tetrakis::refine(cage, "catmull-clark", level);
        const auto surface = tetrakis::refine(cage, "catmull-clark", level, {.limit = true, .normals = true});
        double farthest = 0;
        for (std::size_t v = 0; v < net.positions.size(); ++v)
            farthest = std::max(farthest, glm::distance(net.positions[v], surface.positions[v]));
        std::cout << "level " << level << ": " << net.face_count() << " faces, " << surface.normals.size()
                  << " normals, the net within " << farthest << " of the surface\n";
    }
}
