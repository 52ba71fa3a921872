#include "limit_closest.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../surface/local_frame.hpp"
#include "embree_scene.hpp"
#include "nearest_in_root.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetrakis {

namespace {

/// Newton's method ends where the squared sine of the angle between the way to the surface point and the surface's
/// normal is below this: a further step would change the distance by half of that share.
constexpr double k_square = 1e-8;

/// How many levels of a cell are looked at before a search is cheaper.
constexpr int k_star_levels = 12, k_generic_levels = 4;

/// Of a cell: the hull of more is that of a large ring, which says little about the cell.
constexpr std::size_t k_most_points = 40;

/// Catmull-Clark: roots are the corner cells.
struct QuadRoots {
    static constexpr detail::RootShape shape = detail::RootShape::square;
    using Cell = detail::QuadNode;
    const QuadPatches& patches;

    std::uint32_t count() const { return patches.mesh().halfedge_count(); }
    HalfedgeId root(std::uint32_t i) const { return HalfedgeId(i); }
    Box3d box(HalfedgeId root) const {
        return patches.with_root(root, [](const Cell& cell) {
            Box3d box;
            if (cell.kind == Cell::Kind::regular)
                for (int i = 0; i < k_net_points; ++i) box.add(point(cell.net, i));
            else if (cell.kind == Cell::Kind::star)
                for (const Vec3d& p : cell.star->points) box.add(p);
            else
                for (const Vec3d& p : cell.rings->points()) box.add(p);
            return box;
        });
    }
    const Cell& cell(HalfedgeId root) const { return patches.root_node(root); }
    Vec3d position(HalfedgeId, const Cell& cell, double x, double y) const { return QuadPatches::position(cell, x, y); }

    static const detail::Net16& net(const Cell& cell) { return cell.net; }
    static Vec3d point(const detail::Net16& net, int i) { return {net.c[0][i], net.c[1][i], net.c[2][i]}; }
    static constexpr int k_net_points = 16;
    template <class Test>
    bool all_quarters(const Cell& cell, Test&& test) const {
        const Cell* quarters = cell.grown();
        return std::all_of(quarters, quarters + 4, test);
    }
    static Vec3d star_limit(const Cell& cell) { return cell.star->limit; }
    static double star_reach(const Cell& cell) { return cell.star->reach; }
    static std::vector<Vec3d> points(const Cell& cell) { return cell.rings->points(); }

    /// Moves parameters beyond a root's sides into the roots there; on boundaries, onto the side.
    static void cross_sides(const ControlMesh& mesh, SurfaceParameter& at) {
        double &x = at.x, &y = at.y;
        for (int crossing = 0; crossing < 3; ++crossing) {
            CellSide side;
            if (x < 0)
                side = CellSide::prev_edge;
            else if (y < 0)
                side = CellSide::edge;
            else if (x > 1)
                side = CellSide::next_cell;
            else if (y > 1)
                side = CellSide::prev_cell;
            else
                break;
            const HalfedgeId beyond = across(mesh, at.root, side);
            if (!beyond.valid() || mesh.is_hole(mesh.face(beyond))) break;
            const double old_x = x, old_y = y;
            switch (side) {
                case CellSide::edge:
                    x = -old_y, y = old_x;
                    break;
                case CellSide::prev_edge:
                    x = old_y, y = -old_x;
                    break;
                case CellSide::next_cell:
                    x = old_y, y = 2 - old_x;
                    break;
                case CellSide::prev_cell:
                    x = 2 - old_y, y = old_x;
                    break;
            }
            at.root = beyond;
        }
        x = std::clamp(x, 0.0, 1.0);
        y = std::clamp(y, 0.0, 1.0);
    }
};

/// Loop: roots are the faces.
struct LoopRoots {
    static constexpr detail::RootShape shape = detail::RootShape::triangle;
    using Cell = detail::LoopCell;
    const LoopPatches& patches;

    std::uint32_t count() const { return patches.mesh().face_count(); }
    HalfedgeId root(std::uint32_t i) const { return patches.mesh().face_halfedge(FaceId(i)); }
    Box3d box(HalfedgeId root) const { return patches.bounds(patches.mesh().face(root)); }
    Cell cell(HalfedgeId root) const {
        Cell cell;
        patches.root_cell(root, cell);
        return cell;
    }
    Vec3d position(HalfedgeId root, const Cell&, double x, double y) const { return patches.position(root, x, y); }

    static const detail::Net12& net(const Cell& cell) { return cell.net; }
    static Vec3d point(const detail::Net12& net, int i) { return net[static_cast<std::size_t>(i)]; }
    static constexpr int k_net_points = 12;
    template <class Test>
    bool all_quarters(const Cell& cell, Test&& test) const {
        for (int k = 0; k < 4; ++k) {
            Cell quarter;
            patches.child(cell, k, quarter);
            if (!test(quarter)) return false;
        }
        return true;
    }
    static Vec3d star_limit(const Cell& cell) { return *cell.star->points(); }
    static double star_reach(const Cell& cell) { return cell.star->reach(); }
    static std::vector<Vec3d> points(const Cell& cell) { return cell.node->rings().points(); }

    static void cross_sides(const ControlMesh& mesh, SurfaceParameter& at) {
        std::array<double, 3> b{1 - at.x - at.y, at.x, at.y};
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
        double sum = 0;
        for (double& w : b) sum += w = std::max(w, 0.0);
        at.x = b[1] / sum, at.y = b[2] / sum;
    }
};

auto roots_of(const QuadPatches& patches) { return QuadRoots{patches}; }
auto roots_of(const LoopPatches& patches) { return LoopRoots{patches}; }

/// Whether the surface of a cell is certainly farther from q than `reach`. The boxes of all cells around a vertex hold
/// its ring, so that only their quarters, further down, can be told apart.
template <class Roots>
bool cell_beyond(const Roots& roots, const typename Roots::Cell& cell, const Vec3d& q, double reach, int level) {
    using Kind = typename Roots::Cell::Kind;
    if (cell.kind == Kind::regular)
        return detail::hull_beyond(
            Roots::k_net_points, [&](int i) { return Roots::point(Roots::net(cell), i); }, q, reach);
    if (cell.kind == Kind::star) {
        const double own = Roots::star_reach(cell);
        if (glm::length(q - Roots::star_limit(cell)) - own > reach) return true;
        if (own < reach || level >= k_star_levels) return false;
    } else if (cell.kind == Kind::generic) {
        const auto& points = Roots::points(cell);
        if (points.size() <= k_most_points &&
            detail::hull_beyond(
                static_cast<int>(points.size()), [&](int i) { return points[static_cast<std::size_t>(i)]; }, q, reach))
            return true;
        if (level >= k_generic_levels) return false;
    }
    return roots.all_quarters(
        cell, [&](const typename Roots::Cell& quarter) { return cell_beyond(roots, quarter, q, reach, level + 1); });
}

}  // namespace

template <class Patches>
struct LimitClosest<Patches>::Boxes {
    std::vector<Box3d> box;  ///< of a root's surface; empty in holes
    detail::LocalFrame frame;
    detail::EmbreeScene scene;

    explicit Boxes(std::uint64_t max_memory_bytes) : scene(RTC_SCENE_FLAG_NONE, max_memory_bytes) {}

    static void put_bounds(const RTCBoundsFunctionArguments* args) {
        const auto& boxes = *static_cast<const Boxes*>(args->geometryUserPtr);
        const Box3d& box = boxes.box[args->primID];
        // Embree leaves out primitives with an inverted box.
        const Vec3d lower = box.empty() ? Vec3d(1) : boxes.frame.to_local(box.lower),
                    upper = box.empty() ? Vec3d(-1) : boxes.frame.to_local(box.upper);
        *args->bounds_o = {detail::round_down(lower.x), detail::round_down(lower.y), detail::round_down(lower.z), 0,
                           detail::round_up(upper.x),   detail::round_up(upper.y),   detail::round_up(upper.z),   0};
    }
};

template <class Patches>
LimitClosest<Patches>::LimitClosest(const Patches& patches) : patches_(patches) {
    rounding_ = detail::surface_rounding(patches.mesh());
}

template <class Patches>
LimitClosest<Patches>::~LimitClosest() = default;

template <class Patches>
void LimitClosest<Patches>::prepare(const RunContext& context) const {
    std::call_once(built_, [&] {
        const auto roots = roots_of(patches_);
        const ControlMesh& mesh = patches_.mesh();
        auto boxes = std::make_unique<Boxes>(context.max_memory_bytes);
        boxes->box.resize(roots.count());
        Box3d bounds;
        constexpr std::uint32_t k_boxes_per_report = 4096;
        for (std::uint32_t i = 0; i < roots.count(); ++i) {
            if (i % k_boxes_per_report == 0) context.report("build", static_cast<double>(i) / roots.count());
            const HalfedgeId root = roots.root(i);
            if (mesh.is_hole(mesh.face(root))) continue;
            // Room for the rounding of positions, so that no order of search misses what another one finds.
            Box3d& box = boxes->box[i] = roots.box(root);
            box.lower -= Vec3d(rounding_), box.upper += Vec3d(rounding_);
            bounds.add(box);
        }
        boxes->frame = detail::LocalFrame::of(bounds);
        RTCGeometry geometry = rtcNewGeometry(boxes->scene.device(), RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, roots.count());
        rtcSetGeometryUserData(geometry, boxes.get());
        rtcSetGeometryBoundsFunction(geometry, &Boxes::put_bounds, nullptr);
        with_threads(context, [&] { boxes->scene.build(geometry, context); });
        boxes_ = std::move(boxes);
    });
}

template <class Patches>
double LimitClosest<Patches>::local(const Vec3d& q, SurfaceParameter at) const {
    const auto roots = roots_of(patches_);
    double best = std::numeric_limits<double>::infinity();
    for (int step = 0; step < detail::k_newton_steps; ++step) {
        const SurfacePoint s = detail::with_derivatives(
            roots.shape, at.x, at.y, [&](double x, double y) { return patches_.frame(at.root, x, y); });
        const double distance = glm::length(q - s.position);
        if (distance >= best * (1 - 1e-9)) return std::min(best, distance);
        best = distance;
        double dx, dy;
        if (!detail::tangent_step(s, q, dx, dy)) return best;
        const Vec3d along = dx * s.du + dy * s.dv;
        if (glm::dot(along, along) < k_square * distance * distance) return best;
        // No step longer than half a root: beyond the neighbour the linearisation means nothing.
        const double length = std::max(std::abs(dx), std::abs(dy));
        if (length > 0.5) dx *= 0.5 / length, dy *= 0.5 / length;
        at.x += dx, at.y += dy;
        roots.cross_sides(patches_.mesh(), at);
    }
    return best;
}

template <class Patches>
double LimitClosest<Patches>::global(const Vec3d& q, double best) const {
    prepare({});
    const auto roots = roots_of(patches_);
    const auto exact = [&](std::uint32_t i, double so_far) {
        if (boxes_->box[i].empty()) return std::numeric_limits<double>::infinity();
        const HalfedgeId root = roots.root(i);
        const auto& cell = roots.cell(root);
        if (cell_beyond(roots, cell, q, so_far + rounding_, 0)) return so_far;
        const bool smooth = cell.kind == decltype(roots)::Cell::Kind::regular;
        return std::min(so_far,
                        detail::nearest_in_root(
                            roots.shape, smooth, q, [&](double x, double y) { return patches_.frame(root, x, y); },
                            [&](double x, double y) { return roots.position(root, cell, x, y); }));
    };
    return boxes_->scene.nearest(boxes_->frame, roots.count(), 0, q, best, exact);
}

template class LimitClosest<QuadPatches>;
template class LimitClosest<LoopPatches>;

}  // namespace tetrakis
