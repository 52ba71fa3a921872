#include "adaptive_peers.hpp"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Subdivider/Adaptive/Composite/CompositeT.hh>
#include <OpenMesh/Tools/Subdivider/Adaptive/Composite/RulesT.hh>

#include <vector>

namespace tetrakis::bench {

namespace {

namespace Adaptive = OpenMesh::Subdivider::Adaptive;

struct Traits : Adaptive::CompositeTraits {
    using Point = OpenMesh::Vec3d;
    using Normal = OpenMesh::Vec3d;
};
using Mesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Composite = Adaptive::CompositeT<Mesh>;

struct OpenMeshAdaptive final : AdaptivePeer {
    AdaptiveTask task;
    Mesh control;
    std::vector<std::vector<Mesh::FaceHandle>> rounds;
    std::unique_ptr<Mesh> mesh;
    std::unique_ptr<Composite> composite;

    explicit OpenMeshAdaptive(const AdaptiveTask& t) : task(t) {
        std::vector<Mesh::VertexHandle> vertices;
        for (const Vec3d& p : task.data.positions) vertices.push_back(control.add_vertex({p.x, p.y, p.z}));
        const auto& corner = task.data.face_vertices;
        for (std::size_t i = 0; i + 2 < corner.size(); i += 3)
            control.add_face(vertices[corner[i]], vertices[corner[i + 1]], vertices[corner[i + 2]]);
        prepare();
        for (int round = 0; round < task.rounds; ++round) {
            rounds.emplace_back();
            for (Mesh::FaceHandle face : mesh->faces())
                if (level(face) == round && mesh->data(face).final() && selected(face)) rounds.back().push_back(face);
            split(round);
        }
    }

    void refine() override {
        for (int round = 0; round < task.rounds; ++round) split(round);
    }
    AdaptiveResult result() const override {
        AdaptiveResult result{mesh->n_vertices(), mesh->n_faces()};
        for (Mesh::VertexHandle v : mesh->vertices()) result.moment += mesh->point(v).sqrnorm();
        result.moment /= static_cast<double>(result.vertices);
        return result;
    }

    void prepare() override {
        composite.reset();
        mesh = std::make_unique<Mesh>(control);
        composite = std::make_unique<Composite>(*mesh);
        // The sequences of rules that OpenMesh's own adaptive program uses for these schemes.
        if (task.sqrt3) {
            composite->add<Adaptive::Tvv3<Mesh>>();
            composite->add<Adaptive::VF<Mesh>>();
            composite->add<Adaptive::FF<Mesh>>();
            composite->add<Adaptive::FVc<Mesh>>();
        } else {
            composite->add<Adaptive::Tvv4<Mesh>>();
            composite->add<Adaptive::VdE<Mesh>>();
            composite->add<Adaptive::EVc<Mesh>>();
            composite->add<Adaptive::VdE<Mesh>>();
            composite->add<Adaptive::EVc<Mesh>>();
        }
        composite->initialize();
    }

    // A face's state counts the rules applied to it; the first rule of a level splits it.
    int level(Mesh::FaceHandle face) const {
        const int rules = static_cast<int>(composite->n_rules());
        return (mesh->data(face).state() + rules - 1) / rules;
    }

    bool selected(Mesh::FaceHandle face) const {
        std::array<Vec3d, 3> corner;
        std::size_t k = 0;
        for (Mesh::VertexHandle v : mesh->fv_range(face)) {
            const auto& p = mesh->point(v);
            corner[k++] = {p[0], p[1], p[2]};
        }
        return selects(task.selection, corner);
    }

    void split(int round) {
        // Some faces are already split because of their neighbours.
        for (Mesh::FaceHandle face : rounds[static_cast<std::size_t>(round)])
            if (level(face) <= round) composite->refine(face);
    }
};

}  // namespace

std::unique_ptr<AdaptivePeer> openmesh_adaptive(const AdaptiveTask& task) {
    return std::make_unique<OpenMeshAdaptive>(task);
}

}  // namespace tetrakis::bench
