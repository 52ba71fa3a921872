#include "loop_patches.hpp"

#include "../../refine/rules/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <array>

namespace tetrakis {

namespace detail {

std::vector<Vec3d> LoopShape::beyond(const CornerRing& ring) {
    const int cell = ring.cell;
    const Vec3d& centre = ring.centre;
    std::vector<Vec3d> out;
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

using detail::CornerRing;
using detail::for_each_outgoing;

namespace {

constexpr std::array<Vec2d, 3> k_corner_parameters{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};

/// Whether a vertex is interior, with no sharp tags around it and at least three triangles.
bool is_smooth(const ControlMesh& mesh, VertexId v) {
    bool smooth = !mesh.is_boundary(v) && !is_sharp(mesh.sharpness(v)) && mesh.face_valence(v) > 2;
    if (smooth) for_each_outgoing(mesh, v, [&](HalfedgeId h) { smooth &= !is_sharp(mesh.sharpness(mesh.edge(h))); });
    return smooth;
}

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

CornerRing LoopPatches::root_ring(HalfedgeId root, std::uint32_t corner) const {
    return detail::control_ring(mesh_, SchemeKind::loop, HalfedgeId(root.value + corner));
}

std::optional<detail::LoopStar> LoopPatches::root_star(HalfedgeId root, int& turn) const {
    std::array<HalfedgeId, 3> at;
    std::array<int, 3> valence;
    turn = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        at[k] = HalfedgeId(root.value + static_cast<std::uint32_t>(k));
        const VertexId v = mesh_.origin(at[k]);
        if (!is_smooth(mesh_, v)) return std::nullopt;
        valence[k] = static_cast<int>(mesh_.face_valence(v));
        if (valence[k] != 6) turn = static_cast<int>(k);
    }
    std::ranges::rotate(at, at.begin() + turn);
    std::ranges::rotate(valence, valence.begin() + turn);
    detail::LoopStar star;
    star.resize(valence);
    for (int k = 0; k < 3; ++k) {
        HalfedgeId o = at[static_cast<std::size_t>(k)];
        star.points[static_cast<std::size_t>(k)] = mesh_.position(mesh_.origin(o));
        for (int i = 0; i < star.valence_of(k); ++i, o = mesh_.ccw_outgoing(o))
            if (i >= 2) star.points[star.ring_place(k, i)] = mesh_.position(mesh_.target(o));
    }
    return star;
}

void LoopPatches::build_root(HalfedgeId root, detail::LoopNode& node) const {
    int turn = 0;
    if (auto star = root_star(root, turn))
        node.become(std::move(*star), turn);
    else
        node.become(detail::CellRings<3>{{root_ring(root, 0), root_ring(root, 1), root_ring(root, 2)}});
}

SurfacePoint LoopPatches::vertex(HalfedgeId root, LatticePoint at, int level) const {
    const double scale = 1.0 / (std::uint32_t{1} << level);
    SurfacePoint out = frame(root, at.x * scale, at.y * scale);
    const std::uint32_t side = std::uint32_t{1} << level;
    const std::array<std::uint32_t, 3> b{side - at.x - at.y, at.x, at.y};
    for (std::uint32_t s = 0; s < 3; ++s) {
        if (b[s] == side) out.normal = root_ring(root, s).limit().normal;
        // Is the vertex inside side s of the root?
        if (b[(s + 2) % 3] != 0 || b[s] == 0 || b[(s + 1) % 3] == 0) continue;
        const HalfedgeId h(root.value + s);
        const std::uint32_t t = mesh_.twin(h).value;
        if (t == HalfedgeId::none || mesh_.sharpness(mesh_.edge(h)) != k_sharpness_infinity) continue;
        const Vec2d from = k_corner_parameters[t % 3], to = k_corner_parameters[(t + 1) % 3];
        const Vec2d there = from + (b[s] * scale) * (to - from);
        const SurfacePoint other = frame(HalfedgeId(t - t % 3), there.x, there.y);
        out.normal = unit_or_zero(out.normal + other.normal);
    }
    return out;
}

}  // namespace tetrakis
