#include "corner_angles.hpp"

#include "../../hier/base/error.hpp"
#include "../../schemes/core/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"

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

/// Gives the sectors at v that have no angle the sum of their faces'.
void measure(const ControlMesh& mesh, VertexId v, std::vector<double>& angles) {
    std::vector<HalfedgeId> ring;
    std::vector<float> sharpness;
    const HalfedgeId first = mesh.vertex_halfedge(v);
    for (HalfedgeId h = first; h.valid();) {
        ring.push_back(h);
        sharpness.push_back(mesh.sharpness(mesh.edge(h)));
        const HalfedgeId last = mesh.prev(h);
        h = mesh.ccw_outgoing(h);
        if (h == first) break;
        if (!h.valid()) sharpness.push_back(mesh.sharpness(mesh.edge(last)));
    }
    if (ring.empty() || vertex_rule(sharpness, mesh.sharpness(v)) != VertexRule::corner) return;
    const std::size_t n = ring.size();
    std::size_t start = 0;
    while (start < n && !is_sharp(sharpness[start])) ++start;
    for (std::size_t i = 0, end = 0; i < n; i = end) {
        const auto at = [&](std::size_t k) { return (start + k) % n; };
        double sum = 0;
        for (end = i; end < n && (end == i || !is_sharp(sharpness[at(end)])); ++end)
            sum += corner_of_face(mesh, ring[at(end)]);
        const double angle = usable_corner_angle(sum);
        for (std::size_t k = i; k < end; ++k)
            if (double& own = angles[ring[at(k)].value]; own == 0) own = angle;
    }
}

}  // namespace

std::vector<double> corner_angles(const ControlMesh& mesh, const RuleOptions& rules) {
    std::vector<double> angles;
    if (mesh.has_corner_angles() || rules.measure_corner_angles) {
        angles.resize(mesh.halfedge_count());
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) angles[h] = mesh.corner_angle(HalfedgeId(h));
    }
    if (rules.measure_corner_angles)
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) measure(mesh, VertexId(v), angles);
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
