#include "figure_commands.hpp"

#include "../../eval/io/mesh_reader.hpp"
#include "../../eval/io/mesh_writer.hpp"

#include <cstdint>
#include <stdexcept>

#ifdef TETRAKIS_FIGURES_SIMPLIFY
#    include <meshoptimizer.h>
#endif

namespace tetrakis::figures {

nlohmann::json simplify(const Arguments& arguments) {
    if (arguments.size() != 3) throw std::invalid_argument("simplify: IN.obj TRIANGLES OUT.obj");
#ifdef TETRAKIS_FIGURES_SIMPLIFY
    const TriangleMesh mesh = read_triangle_mesh(arguments[0]);
    std::vector<unsigned> indices;
    for (const auto& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
    std::vector<float> positions;
    for (const Vec3d& p : mesh.positions)
        for (int i = 0; i < 3; ++i) positions.push_back(static_cast<float>(p[i]));
    std::vector<unsigned> left(indices.size());
    // The number of triangles decides, not the error.
    constexpr float k_any_error = 1;
    left.resize(meshopt_simplify(left.data(), indices.data(), indices.size(), positions.data(), mesh.positions.size(),
                                 3 * sizeof(float), 3 * std::stoul(arguments[1]), k_any_error));
    TriangleMesh result;
    std::vector<std::int64_t> number(mesh.positions.size(), -1);
    for (std::size_t i = 0; i < left.size(); ++i) {
        if (number[left[i]] < 0) {
            number[left[i]] = static_cast<std::int64_t>(result.positions.size());
            result.positions.push_back(mesh.positions[left[i]]);
        }
        if (i % 3 == 0) result.triangles.emplace_back();
        result.triangles.back()[i % 3] = static_cast<std::uint32_t>(number[left[i]]);
    }
    write_mesh(arguments[2], result);
    return {{"triangles", result.triangles.size()}};
#else
    throw std::runtime_error("built without meshoptimizer (libmeshoptimizer-dev)");
#endif
}

}  // namespace tetrakis::figures
