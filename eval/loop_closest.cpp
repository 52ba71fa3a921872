#include "tetrakis/eval/loop_closest.hpp"

#include "tetrakis/eval/nearest_in_root.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetrakis {

namespace {

/// Moves barycentrics into the triangle: the nearest point in the parameter plane would do as well; this one is cheap.
void clamp_to_triangle(std::array<double, 3>& b) {
    double sum = 0;
    for (double& w : b) {
        w = std::max(w, 0.0);
        sum += w;
    }
    for (double& w : b) w /= sum;
}

}  // namespace

double LoopClosest::local(const Vec3d& q, SurfaceParameter at) const {
    const ControlMesh& mesh = patches_.mesh();
    double best = std::numeric_limits<double>::infinity();
    for (int step = 0; step < detail::k_newton_steps; ++step) {
        const SurfacePoint s =
            detail::with_derivatives(detail::RootShape::triangle, at.x, at.y,
                                     [&](double x, double y) { return patches_.evaluate(at.root, x, y); });
        const double distance = glm::length(q - s.position);
        if (distance >= best * (1 - 1e-9)) return std::min(best, distance);
        best = distance;
        double dx, dy;
        if (!detail::tangent_step(s, q, dx, dy)) return best;
        // No step longer than half a triangle: beyond the neighbour the linearisation means nothing.
        const double length = std::max(std::abs(dx), std::abs(dy));
        if (length > 0.5) dx *= 0.5 / length, dy *= 0.5 / length;
        std::array<double, 3> b{1 - at.x - dx - at.y - dy, at.x + dx, at.y + dy};
        for (int crossing = 0; crossing < 3; ++crossing) {
            const std::size_t out = static_cast<std::size_t>(std::min_element(b.begin(), b.end()) - b.begin());
            if (b[out] >= 0) break;
            // Beyond the edge opposite corner `out`: the lattice goes on straight, so the corner there is a + b - out.
            const std::uint32_t h0 = mesh.face_halfedge(mesh.face(at.root)).value;
            const std::size_t from = (out + 1) % 3;
            const HalfedgeId t = mesh.twin(HalfedgeId(h0 + static_cast<std::uint32_t>(from)));
            if (!t.valid() || mesh.is_hole(mesh.face(t))) break;
            const double d = -b[out], start = b[from] - d, end = b[(from + 1) % 3] - d;
            const HalfedgeId root = mesh.face_halfedge(mesh.face(t));
            const std::size_t k = t.value - root.value;  // t starts at our edge's end
            b[k] = end, b[(k + 1) % 3] = start, b[(k + 2) % 3] = d;
            at.root = root;
        }
        clamp_to_triangle(b);
        at.x = b[1], at.y = b[2];
    }
    return best;
}

double LoopClosest::in_root(const Vec3d& q, HalfedgeId root, double best) const {
    return std::min(best, detail::nearest_in_root(detail::RootShape::triangle, q,
                                                  [&](double x, double y) { return patches_.evaluate(root, x, y); }));
}

void LoopClosest::prepare(const RunContext& context) const {
    const ControlMesh& mesh = patches_.mesh();
    std::call_once(built_, [&] {
        const auto box_of = [&](std::uint32_t f) {
            Box3d box;
            if (mesh.is_hole(FaceId(f))) return box;
            // The limit of a triangle lies in the hull of the rings of its corners: all weights are positive.
            const std::uint32_t h0 = mesh.face_halfedge(FaceId(f)).value;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const VertexId v = mesh.origin(HalfedgeId(h0 + k));
                const HalfedgeId start = mesh.vertex_halfedge(v);
                box.add(mesh.position(v));
                for (HalfedgeId h = start; h.valid();) {
                    box.add(mesh.position(mesh.target(h)));
                    box.add(mesh.position(mesh.origin(mesh.prev(h))));
                    h = mesh.ccw_outgoing(h);
                    if (h == start) break;
                }
            }
            return box;
        };
        bvh_ = std::make_unique<ClosestBvh>(mesh.face_count(), box_of, context);
    });
}

double LoopClosest::global(const Vec3d& q, double best) const {
    prepare({});
    const ControlMesh& mesh = patches_.mesh();
    const ClosestBvh::Hit hit = bvh_->query(
        q, best, [&](std::uint32_t f, double so_far) { return in_root(q, mesh.face_halfedge(FaceId(f)), so_far); });
    return hit.found() ? std::min(best, hit.distance) : best;
}

}  // namespace tetrakis
