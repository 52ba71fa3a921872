#include "loop_patches.hpp"

#include "../../refine/rules/corner_angles.hpp"
#include "../../schemes/core/sharpness.hpp"

#include <algorithm>
#include <array>

namespace tetrakis {

namespace detail {

namespace {

/// Six neighbours, counter-clockwise from the cell's next corner, with which the regular rules give what this ring's
/// rules give, at this level and below, on the cell's side; empty if there are none. Across a boundary or crease with
/// three triangles on the cell's side the missing neighbours are reflected: c + p_0 - p_1; at a corner with a single
/// triangle, through the centre too.
std::optional<std::array<Vec3d, 6>> regular_neighbours(const CornerRing& ring) {
    const int cell = ring.cell;
    const Vec3d& centre = ring.centre;
    std::array<Vec3d, 6> out;
    if (ring.is_smooth()) {
        if (ring.size() != 6) return {};
        for (int i = 0; i < 6; ++i) out[i] = ring.spoke(cell + i).point;
        return out;
    }
    const auto sector = ring.sector();
    if (!ring.is_stationary() || !sector) return {};
    const auto [first, faces, corner] = *sector;
    const int offset = cell - first;
    const auto p = [&ring, first = first](int i) { return ring.spoke(first + i).point; };
    if (!corner && faces == 3) {
        const std::array<Vec3d, 6> around{p(0), p(1), p(2), p(3), centre + p(3) - p(2), centre + p(0) - p(1)};
        for (int i = 0; i < 6; ++i) out[i] = around[(i + offset) % 6];
        return out;
    }
    if (corner && faces == 1)
        return std::array<Vec3d, 6>{
            p(0), p(1), centre + p(1) - p(0), 2.0 * centre - p(0), 2.0 * centre - p(1), centre + p(0) - p(1)};
    return {};
}

}  // namespace

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

bool LoopShape::find_patch(const CellRings<3>& rings, Net12& net) {
    std::array<std::array<Vec3d, 6>, 3> around;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto found = regular_neighbours(rings.corner[k]);
        if (!found) return false;
        around[k] = *found;
        net[k] = rings.corner[k].centre;
    }
    const auto& [a, b, c] = around;
    std::ranges::copy(std::array{a[2], a[3], a[4], a[5], b[3], b[4], b[5], c[3], c[4]}, net.begin() + 3);
    return true;
}

std::unique_ptr<LoopStar> LoopShape::find_star(const CellRings<3>& rings, int& corner) {
    const auto irregular =
        std::ranges::find_if(rings.corner, [](const CornerRing& r) { return r.is_smooth() && r.size() != 6; });
    if (irregular == rings.corner.end()) return nullptr;
    corner = static_cast<int>(irregular - rings.corner.begin());
    const auto a = regular_neighbours(rings.corner[static_cast<std::size_t>((corner + 1) % 3)]);
    const auto b = regular_neighbours(rings.corner[static_cast<std::size_t>((corner + 2) % 3)]);
    if (!a || !b) return nullptr;
    auto star = std::make_unique_for_overwrite<LoopStar>();
    star->resize({irregular->size(), 6, 6});
    Vec3d* out = star->points.data();
    *out++ = irregular->centre;
    for (int i = 0; i < irregular->size(); ++i) *out++ = irregular->spoke(irregular->cell + i).point;
    std::ranges::copy(std::array{(*a)[3], (*a)[4], (*a)[5], (*b)[3], (*b)[4]}, out);
    return star;
}

void LoopShape::grow_star(const LoopStar& star, int turn, std::array<LoopNode, 4>& quarters) {
    std::array<LoopStar, 4> grown;
    subdivide(star, grown);
    for (int k = 0; k < 4; ++k) {
        LoopStar& part = grown[static_cast<std::size_t>(k)];
        const int corner = k == 3 ? turn : (k + turn) % 3;
        LoopNode& quarter = quarters[static_cast<std::size_t>(k == 3 ? 3 : corner)];
        if (part.regular())
            quarter.patch = part.net(corner);
        else
            quarter.become(std::make_unique<LoopStar>(std::move(part)), corner);
    }
}

}  // namespace detail

using detail::CornerRing;
using detail::for_each_outgoing;

namespace {

constexpr std::array<Vec2d, 3> k_corner_parameters{Vec2d(0, 0), Vec2d(1, 0), Vec2d(0, 1)};

const ControlMesh& checked_triangles(const ControlMesh& mesh, const RunContext& context) {
    detail::refuse_corner_angles(mesh);
    if (!mesh.all_triangles())
        throw Error(ErrorCode::invalid_input,
                    "Loop subdivision needs triangles, but some faces have more corners; triangulate first");
    detail::check_memory("the patch trees need",
                         mesh.halfedge_count() * sizeof(detail::LoopNode*) + mesh.vertex_count(),
                         context.max_memory_bytes, "raise the limit");
    return mesh;
}

}  // namespace

LoopPatches::LoopPatches(const ControlMesh& mesh, const RunContext& context)
    : PatchTree(checked_triangles(mesh, context)), smooth_(mesh.vertex_count()) {
    for_each_index(mesh.vertex_count(), [&](std::uint32_t i) {
        const VertexId v(i);
        bool smooth =
            !mesh.is_isolated(v) && !mesh.is_boundary(v) && !is_sharp(mesh.sharpness(v)) && mesh.face_valence(v) > 2;
        if (smooth)
            for_each_outgoing(mesh, v, [&](HalfedgeId h) { smooth &= !is_sharp(mesh.sharpness(mesh.edge(h))); });
        smooth_[i] = smooth;
    });
}

CornerRing LoopPatches::root_ring(HalfedgeId root, std::uint32_t corner) const {
    return detail::control_ring(mesh_, SchemeKind::loop, HalfedgeId(root.value + corner));
}

std::unique_ptr<detail::LoopStar> LoopPatches::root_star(HalfedgeId root, int& turn) const {
    std::array<HalfedgeId, 3> at;
    std::array<int, 3> valence;
    turn = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        at[k] = HalfedgeId(root.value + static_cast<std::uint32_t>(k));
        const VertexId v = mesh_.origin(at[k]);
        if (smooth_[v.value] == 0) return nullptr;
        valence[k] = static_cast<int>(mesh_.face_valence(v));
        if (valence[k] != 6) turn = static_cast<int>(k);
    }
    std::ranges::rotate(at, at.begin() + turn);
    std::ranges::rotate(valence, valence.begin() + turn);
    auto star = std::make_unique_for_overwrite<detail::LoopStar>();
    star->resize(valence);
    Vec3d *out = star->points.data(), *const end = out + star->points.size();
    for (const HalfedgeId h : at) *out++ = mesh_.position(mesh_.origin(h));
    for (std::size_t k = 0; k < 3; ++k) {
        HalfedgeId o = at[k];
        // Neighbours that are corners, or a corner's before, are known.
        for (int i = 0; i < valence[k] && out != end; ++i, o = mesh_.ccw_outgoing(o))
            if (i >= (k == 0 ? 2 : 3)) *out++ = mesh_.position(mesh_.target(o));
    }
    return star;
}

void LoopPatches::build_root(HalfedgeId root, detail::LoopNode& node) const {
    int turn = 0;
    auto star = root_star(root, turn);
    if (!star)
        node.become(detail::CellRings<3>{{root_ring(root, 0), root_ring(root, 1), root_ring(root, 2)}});
    else if (star->regular())
        node.patch = star->net(0);
    else
        node.become(std::move(star), turn);
}

SurfacePoint LoopPatches::vertex(HalfedgeId root, LatticePoint at, int level) const {
    const double scale = 1.0 / (std::uint32_t{1} << level);
    SurfacePoint out = frame(root, at.x * scale, at.y * scale);
    const std::uint32_t side = std::uint32_t{1} << level;
    const std::array<std::uint32_t, 3> b{side - at.x - at.y, at.x, at.y};
    for (std::uint32_t s = 0; s < 3; ++s) {
        if (b[s] == side) out.normal = root_ring(root, s).limit().normal;
        // On side s of the root, at parameter t along it?
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
