#include "quad_patches.hpp"

#include <cmath>

namespace tetrakis {

namespace {
bool is_hard(const ControlMesh& mesh, HalfedgeId h) {
    return mesh.twin(h).valid() && mesh.sharpness(mesh.edge(h)) == k_sharpness_infinity;
}
}  // namespace

SurfacePoint QuadPatches::vertex(HalfedgeId root, LatticePoint at, int level) const {
    const double step = std::ldexp(1.0, -level);
    SurfacePoint point = frame(root, at.x * step, at.y * step);
    const ControlMesh& m = mesh_;
    const auto normal_at = [&](HalfedgeId h, std::uint32_t x, std::uint32_t y) {
        return frame(h, x * step, y * step).normal;
    };
    Vec3d sum(0);
    if (at.x == 0 && at.y == 0) {
        // A control vertex with hard edges: the mean over its corner cells.
        bool hard = false;
        const HalfedgeId start = m.vertex_halfedge(m.origin(root));
        for (HalfedgeId h = start; h.valid();) {
            hard |= is_hard(m, h);
            h = m.ccw_outgoing(h);
            if (h == start) break;
        }
        if (!hard) return point;
        for (HalfedgeId h = start; h.valid();) {
            sum += normal_at(h, 0, 0);
            h = m.ccw_outgoing(h);
            if (h == start) break;
        }
    } else if (at.y == 0 && is_hard(m, root)) {
        sum = point.normal + normal_at(m.cw_outgoing(root), 0, at.x);
    } else if (at.x == 0 && is_hard(m, m.prev(root))) {
        sum = point.normal + normal_at(m.ccw_outgoing(root), at.y, 0);
    } else {
        return point;
    }
    const double length = glm::length(sum);
    if (length > 0) point.normal = sum / length;
    return point;
}

}  // namespace tetrakis
