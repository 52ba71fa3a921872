#include "uniform_peers.hpp"

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/subdivision_method_3.h>

#include <vector>

namespace tetrakis::bench {

std::function<std::uint64_t()> cgal_uniform(const UniformTask& task) {
    using Mesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;
    auto mesh = std::make_shared<Mesh>();
    std::vector<Mesh::Vertex_index> vertices, face;
    for (const Vec3d& p : task.data.positions) vertices.push_back(mesh->add_vertex({p.x, p.y, p.z}));
    for (std::size_t f = 0; f + 1 < task.data.face_offsets.size(); ++f) {
        face.clear();
        for (std::uint32_t i = task.data.face_offsets[f]; i < task.data.face_offsets[f + 1]; ++i)
            face.push_back(vertices[task.data.face_vertices[i]]);
        if (mesh->add_face(face) == Mesh::null_face()) return {};
    }
    return [mesh, scheme = task.scheme, levels = task.levels]() -> std::uint64_t {
        const auto steps = CGAL::parameters::number_of_iterations(levels);
        if (scheme == "sqrt3")
            CGAL::Subdivision_method_3::Sqrt3_subdivision(*mesh, steps);
        else if (scheme == "doo-sabin")
            CGAL::Subdivision_method_3::DooSabin_subdivision(*mesh, steps);
        else if (scheme == "loop")
            CGAL::Subdivision_method_3::Loop_subdivision(*mesh, steps);
        else
            CGAL::Subdivision_method_3::CatmullClark_subdivision(*mesh, steps);
        return mesh->number_of_vertices();
    };
}

}  // namespace tetrakis::bench
