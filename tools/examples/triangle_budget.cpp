// The best mesh with at most a given number of triangles, and its distance from the surface.
#include <tetrakis/tetrakis.hpp>

#include <cstdint>
#include <iostream>

int main() {
    const auto cage = tetrakis::load_control_mesh("data/rook.obj");
    for (const std::uint64_t budget : {1000, 2000, 4000}) {
        // `measure` samples the result, which takes many times longer than making it.
        const auto result =
            tetrakis::tessellate(cage, {.max_triangles = budget, .measure = true, .measure_samples = 50'000});
        std::cout << "at most " << budget << ": " << result.mesh.triangles.size() << " triangles, "
                  << result.measured_error->hausdorff << " from the surface as measured, " << *result.certified_error
                  << " at most as proven\n";
        if (result.mesh.triangles.size() > budget) return 1;
    }
}
