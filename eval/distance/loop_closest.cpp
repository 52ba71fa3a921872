#include "loop_closest.hpp"

#include "hull_beyond.hpp"
#include "nearest_in_root.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetrakis {

namespace {

/// Building the hierarchy costs as much as looking at all boxes a few hundred times (measured: 4500 and 12 instructions
/// a box).
constexpr std::uint32_t k_plain_searches = 256;

/// Of a position, in units of the largest coordinate.
constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

/// Squared sine of the angle between the way to a surface point and the surface's normal below which the foot is found:
/// what is left then changes the distance by half of that.
constexpr double k_square = 1e-8;

/// How often a regular cell is cut up, and how many levels of others are looked at, before a search is cheaper.
constexpr int k_net_cuts = 3, k_star_levels = 12, k_generic_levels = 4;

/// Of a cell: the hull of more is that of a large ring, which says little about the cell.
constexpr std::size_t k_most_points = 40;

bool net_beyond(const detail::Net12& net, const Vec3d& q, double reach, int cuts) {
    if (detail::hull_beyond(
            12, [&](int i) { return net[static_cast<std::size_t>(i)]; }, q, reach))
        return true;
    if (cuts == 0) return false;
    // A net is the star of valence six.
    constexpr int k_regular = 6;
    std::array<Vec3d, detail::loop_star_step_size(k_regular)> step;
    detail::loop_star_step(k_regular, detail::loop_vertex_rule(k_regular).beta, net.data(), step.data());
    for (int k = 0; k < 4; ++k) {
        detail::Net12 quarter;
        if (k == 0)
            std::copy_n(step.begin(), quarter.size(), quarter.begin());
        else
            detail::loop_star_quarter(k_regular, step.data(), k, quarter);
        if (!net_beyond(quarter, q, reach, cuts - 1)) return false;
    }
    return true;
}

/// Whether the surface of a cell is certainly farther from q than `reach`. The boxes of the triangles around a vertex
/// all hold its ring; what is beside it is told apart further down only.
bool cell_beyond(const LoopPatches& patches, const detail::LoopCell& cell, const Vec3d& q, double reach, int level) {
    using Kind = detail::LoopCell::Kind;
    if (cell.kind == Kind::regular) return net_beyond(cell.net, q, reach, k_net_cuts);
    if (cell.kind == Kind::star) {
        const double own = cell.star->reach();
        if (glm::length(q - *cell.star->points()) - own > reach) return true;
        if (own < reach || level >= k_star_levels) return false;
    } else if (cell.kind == Kind::generic) {
        const std::vector<Vec3d> points = cell.node->rings().points();
        if (points.size() <= k_most_points &&
            detail::hull_beyond(
                static_cast<int>(points.size()), [&](int i) { return points[static_cast<std::size_t>(i)]; }, q, reach))
            return true;
        if (level >= k_generic_levels) return false;
    }
    for (int k = 0; k < 4; ++k) {
        detail::LoopCell quarter;
        patches.child(cell, k, quarter);
        if (!cell_beyond(patches, quarter, q, reach, level + 1)) return false;
    }
    return true;
}

/// A box of the cell of a star with a large ring: of its regular parts, and of what is left after a few steps. The tree
/// does not grow by it.
void add_large_star(const detail::LoopStarChain& star, Box3d& box) {
    constexpr int k_steps = 8;
    const int n = star.valence();
    const double beta = detail::loop_vertex_rule(n).beta;
    std::vector<Vec3d> at(star.points(), star.points() + detail::loop_star_size(n)),
        step(static_cast<std::size_t>(detail::loop_star_step_size(n)));
    for (int i = 0; i < k_steps; ++i) {
        detail::loop_star_step(n, beta, at.data(), step.data());
        for (int quarter = 1; quarter < 4; ++quarter)
            for (const Vec3d& p : detail::loop_star_quarter(n, step.data(), quarter)) box.add(p);
        std::copy_n(step.begin(), at.size(), at.begin());
    }
    for (const Vec3d& p : at) box.add(p);
}

/// A box that holds the surface of a root.
Box3d root_box(const LoopPatches& patches, FaceId face) {
    using Kind = detail::LoopCell::Kind;
    const ControlMesh& mesh = patches.mesh();
    const HalfedgeId root = mesh.face_halfedge(face);
    std::uint32_t most = 0;
    for (std::uint32_t k = 0; k < 3; ++k)
        most = std::max(most, mesh.face_valence(mesh.origin(HalfedgeId(root.value + k))));
    detail::LoopCell cell;
    if (most > k_most_points) patches.root_cell(root, cell);
    if (most <= k_most_points || cell.kind == Kind::generic) return patches.bounds(face);
    Box3d box;
    const auto add = [&](const detail::LoopCell& part) {
        if (part.kind == Kind::star)
            add_large_star(*part.star, box);
        else
            for (const Vec3d& p : part.net) box.add(p);
    };
    if (cell.kind != Kind::split) {
        add(cell);
        return box;
    }
    for (int k = 0; k < 4; ++k) {
        detail::LoopCell quarter;
        patches.child(cell, k, quarter);
        add(quarter);
    }
    return box;
}

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
                                     [&](double x, double y) { return patches_.tangents(at.root, x, y); });
        const double distance = glm::length(q - s.position);
        if (distance >= best * (1 - 1e-9)) return std::min(best, distance);
        best = distance;
        double dx, dy;
        if (!detail::tangent_step(s, q, dx, dy)) return best;
        const Vec3d along = dx * s.du + dy * s.dv;
        if (glm::dot(along, along) < k_square * distance * distance) return best;
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
    detail::LoopCell cell;
    patches_.root_cell(root, cell);
    if (cell_beyond(patches_, cell, q, best + k_rounding * patches_.largest_coordinate(), 0)) return best;
    return std::min(
        best, detail::nearest_in_root(
                  detail::RootShape::triangle, q, [&](double x, double y) { return patches_.tangents(root, x, y); },
                  [&](double x, double y) { return patches_.position(root, x, y); }));
}

void LoopClosest::prepare(const RunContext& context) const {
    std::call_once(built_, [&] {
        bvh_ = std::make_unique<ClosestBvh>(boxes(), context);
        searches_.store(k_plain_searches, std::memory_order_relaxed);
    });
}

const std::vector<Box3d>& LoopClosest::boxes() const {
    const ControlMesh& mesh = patches_.mesh();
    std::call_once(boxed_, [&] {
        // Not in parallel: a thread that waits inside might take up a task that comes back here.
        boxes_.resize(mesh.face_count());
        // Room for the rounding of positions, so that no order of search misses what another one finds.
        const Vec3d room(k_rounding * patches_.largest_coordinate());
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            if (mesh.is_hole(FaceId(f))) continue;
            boxes_[f] = root_box(patches_, FaceId(f));
            boxes_[f].lower -= room;
            boxes_[f].upper += room;
        }
    });
    return boxes_;
}

double LoopClosest::global(const Vec3d& q, double best) const {
    const ControlMesh& mesh = patches_.mesh();
    if (searches_.fetch_add(1, std::memory_order_relaxed) < k_plain_searches) {
        const std::vector<Box3d>& all = boxes();
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            // Most are too far along the first axis already.
            const Box3d& box = all[f];
            const double x = std::max({box.lower.x - q.x, q.x - box.upper.x, 0.0});
            if (x > best) continue;
            if (box.empty()) continue;
            const double y = std::max({box.lower.y - q.y, q.y - box.upper.y, 0.0});
            const double z = std::max({box.lower.z - q.z, q.z - box.upper.z, 0.0});
            if (x * x + y * y + z * z <= best * best) best = in_root(q, mesh.face_halfedge(FaceId(f)), best);
        }
        return best;
    }
    prepare({});
    const ClosestBvh::Hit hit = bvh_->query(
        q, best, [&](std::uint32_t f, double so_far) { return in_root(q, mesh.face_halfedge(FaceId(f)), so_far); });
    return hit.found() ? std::min(best, hit.distance) : best;
}

}  // namespace tetrakis
