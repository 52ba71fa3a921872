#include "tetrakis/refine/rule_refinement.hpp"

#include "tetrakis/hier/error.hpp"

#include <limits>
#include <stdexcept>

namespace tetrakis {

RuleMesh rule_mesh(const ControlMesh& mesh) {
    const ControlMeshData& data = mesh.data();
    RuleMesh::Builder faces;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        for (std::uint32_t h = data.face_offsets[f]; h < data.face_offsets[f + 1]; ++h)
            faces.corner(static_cast<int>(data.face_vertices[h]), mesh.sharpness(mesh.edge(HalfedgeId(h))));
        faces.end_face();
    }
    std::vector<float> sharpness(mesh.vertex_count());
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) sharpness[v] = mesh.sharpness(VertexId(v));
    return RuleMesh(static_cast<int>(mesh.vertex_count()), std::move(faces), std::move(sharpness));
}

PolygonMesh refine_by_rules(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RuleOptions& options) {
    if (levels < 0)
        throw Error(ErrorCode::invalid_input, "the number of levels must not be negative; 0 is the control mesh");
    // No step makes more than nine faces of one, or six half-edges of one.
    constexpr int k_most_growth = 9;
    PolygonMesh result;
    try {
        RuleMesh level = rule_mesh(mesh);
        std::vector<Vec3d> positions = mesh.data().positions;
        for (int i = 0; i < levels; ++i) {
            if (level.halfedge_count() > std::numeric_limits<int>::max() / k_most_growth)
                throw Error(ErrorCode::unsupported,
                            "so many levels have more elements than can be counted; ask for fewer");
            RuleStep step = scheme.step(level, options);
            std::vector<Vec3d> finer(step.mesh.vertex_count());
            step.stencils.apply<Vec3d>(positions, finer);
            level = std::move(step.mesh);
            positions = std::move(finer);
        }
        result.positions = std::move(positions);
        result.face_offsets.push_back(0);
        for (int f = 0; f < level.face_count(); ++f) {
            for (const int v : level.corners(f)) result.face_vertices.push_back(static_cast<std::uint32_t>(v));
            result.face_offsets.push_back(static_cast<std::uint32_t>(result.face_vertices.size()));
        }
    } catch (const std::invalid_argument& e) {
        throw Error(ErrorCode::invalid_input, e.what());
    }
    return result;
}

}  // namespace tetrakis
