#include "missing_ring.hpp"

#include <utility>
#include <vector>

namespace tetrakis::detail {

ControlMesh with_missing_ring(const ControlMesh& mesh) {
    ControlMeshData data;
    data.source = mesh.data().source;
    data.positions = mesh.data().positions;
    data.face_offsets = mesh.data().face_offsets;
    data.face_vertices = mesh.data().face_vertices;
    std::vector<std::uint32_t> outer(mesh.vertex_count(), 0);  // 0: none
    const auto beyond = [&](VertexId v) {
        std::uint32_t& of = outer[v.value];
        if (of == 0) {
            of = static_cast<std::uint32_t>(data.positions.size());
            data.positions.emplace_back(0);  // a mesh has numbers only
        }
        return of;
    };
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i);
        if (mesh.twin(h).valid()) continue;
        const VertexId u = mesh.origin(h), v = mesh.target(h);
        for (const std::uint32_t corner : {v.value, u.value, beyond(u), beyond(v)})
            data.face_vertices.push_back(corner);
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
    }
    return ControlMesh::build(std::move(data));
}

RuleOptions inside_missing_ring(RuleOptions rules) {
    rules.averaging_boundary = AveragingBoundary::replicate;
    return rules;
}

}  // namespace tetrakis::detail
