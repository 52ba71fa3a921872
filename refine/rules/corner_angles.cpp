#include "corner_angles.hpp"

#include "../../hier/base/error.hpp"
#include "../../schemes/core/corner_angles.hpp"
#include "rule_refiner.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetrakis::detail {

namespace {

/// Interior angle of the half-edge's face at its origin; above pi where the face is concave there.
double corner_of_face(const ControlMesh& mesh, HalfedgeId h) {
    const Vec3d& at = mesh.position(mesh.origin(h));
    const Vec3d ahead = mesh.position(mesh.target(h)) - at, behind = mesh.position(mesh.origin(mesh.prev(h))) - at;
    const Vec3d across = glm::cross(ahead, behind);
    Vec3d normal(0);
    for (HalfedgeId side = mesh.next(h); mesh.next(side) != h; side = mesh.next(side))
        normal += glm::cross(mesh.position(mesh.origin(side)) - at, mesh.position(mesh.target(side)) - at);
    const double angle = std::atan2(glm::length(across), glm::dot(ahead, behind));
    return glm::dot(across, normal) < 0 ? 2 * std::numbers::pi - angle : angle;
}

}  // namespace

std::vector<double> corner_angles(const ControlMesh& mesh, const RuleOptions& rules) {
    std::vector<double> angles;
    if (mesh.has_corner_angles() || rules.measure_corner_angles) {
        angles.resize(mesh.halfedge_count());
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) angles[h] = mesh.corner_angle(HalfedgeId(h));
    }
    if (rules.measure_corner_angles) {
        // In a sector at a corner, half-edges without an angle get the sum of the angles of the sector's faces.
        const RuleMesh sectors = rule_mesh(mesh);
        for (int v = 0; v < sectors.vertex_count(); ++v) {
            if (sectors.first(v) == RuleMesh::none || sectors.rule(v) != VertexRule::corner) continue;
            sectors.for_each_leaving(v, [&](int h) {
                if (angles[h] != 0) return;
                const RuleMesh::Ring sector = sectors.sector(h);
                double sum = 0;
                for (const int of : sector.halfedge) sum += corner_of_face(mesh, HalfedgeId(of));
                for (const int of : sector.halfedge)
                    if (angles[of] == 0) angles[of] = usable_corner_angle(sum);
            });
        }
    }
    if (std::all_of(angles.begin(), angles.end(), [](double a) { return a == 0; })) angles.clear();
    return angles;
}

void refuse_corner_angles(const ControlMesh& mesh) {
    if (!mesh.has_corner_angles()) return;
    throw Error(
        ErrorCode::unsupported,
        "the control mesh has corner angles, and this knows the plain rules alone; use refine(), a Hierarchy or "
        "tessellate(), or leave out the tags",
        mesh.data().source);
}

}  // namespace tetrakis::detail
