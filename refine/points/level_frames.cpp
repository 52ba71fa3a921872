#include "level_frames.hpp"

namespace tetrakis::detail {

LimitPoint frame_from(const Vec3d& position, const Vec3d& area_normal, const Vec3d& towards) {
    LimitPoint result;
    result.position = position;
    const double length = glm::length(area_normal);
    if (!(length > 0)) return result;
    result.normal = area_normal / length;
    result.tangent1 = towards - glm::dot(towards, result.normal) * result.normal;
    result.tangent2 = glm::cross(result.normal, result.tangent1);
    result.has_tangent_plane = true;
    return result;
}

LimitPoint control_frame(const ControlMesh& mesh, VertexId v) {
    Vec3d normal(0);
    const HalfedgeId start = mesh.vertex_halfedge(v);
    const Vec3d centre = mesh.position(v);
    HalfedgeId h = start;
    do {
        // Twice the vector area of the face, by its triangles around this corner.
        for (HalfedgeId k = mesh.next(h); mesh.target(k) != v; k = mesh.next(k))
            normal += glm::cross(mesh.position(mesh.origin(k)) - centre, mesh.position(mesh.target(k)) - centre);
        h = mesh.ccw_outgoing(h);
    } while (h.valid() && h != start);
    return frame_from(centre, normal, mesh.position(mesh.target(start)) - centre);
}

}  // namespace tetrakis::detail
