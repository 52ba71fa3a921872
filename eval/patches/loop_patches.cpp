#include "loop_patches.hpp"

#include "../../refine/rules/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <array>

namespace tetrakis {

namespace detail {

OuterPoints LoopShape::beyond(const CornerRing& ring) {
    const int cell = ring.cell;
    const Vec3d& centre = ring.centre;
    OuterPoints out;
    if (ring.is_smooth()) {
        for (int i = 2; i < ring.size(); ++i) out.push_back(ring.spoke(cell + i).point);
        return out;
    }
    const auto sector = ring.sector();
    if (!ring.is_stationary() || !sector) return {};
    const auto [first, faces, corner] = *sector;
    const int offset = cell - first;
    const auto p = [&ring, first = first](int i) { return ring.spoke(first + i).point; };
    if (!corner && faces == 3) {
        const std::array<Vec3d, 6> around{p(0), p(1), p(2), p(3), centre + p(3) - p(2), centre + p(0) - p(1)};
        for (int i = 2; i < 6; ++i) out.push_back(around[(i + offset) % 6]);
        return out;
    }
    if (corner && faces == 1)
        return {centre + p(1) - p(0), 2.0 * centre - p(0), 2.0 * centre - p(1), centre + p(0) - p(1)};
    return {};
}

SurfacePoint LoopShape::evaluate(const Net12& net, const Vec2d& at, bool second) {
    const BezierTriangle<2> p = box_spline_triangle(net).around<2>(bary(at));
    const BezierTriangle<1> q = p.around<1>(bary(at));
    SurfacePoint point{position(net, at), 4.0 * (q(1, 0) - q(0, 0)), 4.0 * (q(0, 1) - q(0, 0))};
    if (!second) return point;
    point.duu = 12.0 * (p(2, 0) - 2.0 * p(1, 0) + p(0, 0));
    point.duv = 12.0 * (p(1, 1) - p(1, 0) - p(0, 1) + p(0, 0));
    point.dvv = 12.0 * (p(0, 2) - 2.0 * p(0, 1) + p(0, 0));
    return point;
}

}  // namespace detail

namespace {

const ControlMesh& checked_triangles(const ControlMesh& mesh, const RunContext& context) {
    detail::refuse_corner_angles(mesh);
    if (!mesh.all_triangles())
        throw Error(ErrorCode::invalid_input,
                    "Loop subdivision needs triangles, but some faces have more corners; triangulate first");
    detail::check_memory("the patch trees need", mesh.halfedge_count() * sizeof(detail::LoopNode*),
                         context.max_memory_bytes, "raise the limit");
    return mesh;
}

}  // namespace

LoopPatches::LoopPatches(const ControlMesh& mesh, const RunContext& context)
    : PatchTree(checked_triangles(mesh, context), context) {}

void LoopPatches::build_root(HalfedgeId root, detail::LoopNode& node) const {
    node.become({{ring(root), ring(mesh_.next(root)), ring(mesh_.prev(root))}});
}

}  // namespace tetrakis
