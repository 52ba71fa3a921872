#include "uniform_peers.hpp"

#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/CatmullClarkT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/LoopT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/ModifiedButterFlyT.hh>
#include <OpenMesh/Tools/Subdivider/Uniform/Sqrt3T.hh>

#include <vector>

namespace tetrakis::bench {

namespace {

struct Traits : OpenMesh::DefaultTraits {
    using Point = OpenMesh::Vec3d;
    using Normal = OpenMesh::Vec3d;
};

template <class Mesh, class Subdivider>
std::function<std::uint64_t()> refine(const UniformTask& task) {
    auto mesh = std::make_shared<Mesh>();
    std::vector<typename Mesh::VertexHandle> vertices, face;
    for (const Vec3d& p : task.data.positions) vertices.push_back(mesh->add_vertex(OpenMesh::Vec3d(p.x, p.y, p.z)));
    for (std::size_t f = 0; f + 1 < task.data.face_offsets.size(); ++f) {
        face.clear();
        for (std::uint32_t i = task.data.face_offsets[f]; i < task.data.face_offsets[f + 1]; ++i)
            face.push_back(vertices[task.data.face_vertices[i]]);
        if (!mesh->add_face(face).is_valid()) return {};
    }
    return [mesh, levels = task.levels] {
        Subdivider subdivider;
        subdivider.attach(*mesh);
        subdivider(static_cast<std::size_t>(levels));
        subdivider.detach();
        return static_cast<std::uint64_t>(mesh->n_vertices());
    };
}

}  // namespace

std::function<std::uint64_t()> openmesh_uniform(const UniformTask& task) {
    namespace Uniform = OpenMesh::Subdivider::Uniform;
    using Quads = OpenMesh::PolyMesh_ArrayKernelT<Traits>;
    using Triangles = OpenMesh::TriMesh_ArrayKernelT<Traits>;
    if (task.scheme == "modified-butterfly")
        return refine<Triangles, Uniform::ModifiedButterflyT<Triangles, double>>(task);
    if (task.scheme == "sqrt3") return refine<Triangles, Uniform::Sqrt3T<Triangles, double>>(task);
    if (task.scheme == "loop") return refine<Triangles, Uniform::LoopT<Triangles, double>>(task);
    return refine<Quads, Uniform::CatmullClarkT<Quads, double>>(task);
}

}  // namespace tetrakis::bench
