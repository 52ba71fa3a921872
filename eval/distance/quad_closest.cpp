#include "quad_closest.hpp"

#include "../../hier/forest/corner_cell.hpp"
#include "hull_beyond.hpp"
#include "nearest_in_root.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace tetrakis {

namespace {

void add_net(const detail::Net16& net, Box3d& box) {
    for (int i = 0; i < 16; ++i) box.add(Vec3d(net.c[0][i], net.c[1][i], net.c[2][i]));
}

/// Of a cell: the hull of more is that of a large ring, which says little about the cell.
constexpr std::size_t k_most_points = 40;

/// A box of the cell of a star with a large ring: of its regular parts, and of what is left after a few steps. The tree
/// does not grow by it.
void add_large_star(const detail::QuadStar& star, Box3d& box) {
    constexpr int k_steps = 8;
    std::array<detail::QuadStar, 2> finer;
    const detail::QuadStar* at = &star;
    for (std::size_t step = 0; step < k_steps; ++step) {
        std::array<detail::Net16, 3> regular;
        subdivide(*at, finer[step % 2], regular);
        for (const detail::Net16& net : regular) add_net(net, box);
        at = &finer[step % 2];
    }
    for (const Vec3d& p : at->points) box.add(p);
}

void add_node(const detail::QuadNode& node, Box3d& box) {
    using Kind = detail::QuadNode::Kind;
    if (node.kind == Kind::regular) {
        add_net(node.net, box);
    } else if (node.kind == Kind::star) {
        if (node.star->points.size() > k_most_points)
            add_large_star(*node.star, box);
        else
            for (const Vec3d& p : node.star->points) box.add(p);
    } else if (node.local->points.size() > k_most_points && node.depth == 0) {
        const detail::QuadNode* quarters = node.grown();
        for (int k = 0; k < 4; ++k) add_node(quarters[k], box);
    } else {
        for (const Vec3d& p : node.local->points) box.add(p);
    }
}

Box3d node_box(const detail::QuadNode& node) {
    Box3d box;
    add_node(node, box);
    return box;
}

/// Of a position, in units of the largest coordinate.
constexpr double k_rounding = 128 * std::numeric_limits<double>::epsilon();

/// How often a regular cell is cut up, and how many levels of others are looked at, before a search is cheaper.
constexpr int k_net_cuts = 3, k_star_levels = 12, k_generic_levels = 4;

bool net_beyond(const detail::Net16& net, const Vec3d& q, double reach, int cuts) {
    if (detail::hull_beyond(
            16, [&](int i) { return Vec3d(net.c[0][i], net.c[1][i], net.c[2][i]); }, q, reach))
        return true;
    if (cuts == 0) return false;
    for (int k = 0; k < 4; ++k) {
        detail::Net16 quarter;
        detail::child_net(net, k & 1, k >> 1, quarter);
        if (!net_beyond(quarter, q, reach, cuts - 1)) return false;
    }
    return true;
}

/// Whether the surface of a cell is certainly farther from q than `reach`. The boxes of the cells around a vertex all
/// hold its ring; what is beside it is told apart further down only.
bool cell_beyond(const detail::QuadNode& node, const Vec3d& q, double reach) {
    using Kind = detail::QuadNode::Kind;
    if (node.kind == Kind::regular) return net_beyond(node.net, q, reach, node.crease ? 0 : k_net_cuts);
    if (node.kind == Kind::star) {
        const double own = node.star->reach;
        if (glm::length(q - node.star->limit) - own > reach) return true;
        if (own < reach || node.depth >= k_star_levels) return false;
    } else {
        const auto& points = node.local->points;
        if (points.size() <= k_most_points &&
            detail::hull_beyond(
                static_cast<int>(points.size()), [&](int i) { return points[static_cast<std::size_t>(i)]; }, q, reach))
            return true;
        if (node.depth >= k_generic_levels) return false;
    }
    const detail::QuadNode* quarters = node.grown();
    return std::all_of(quarters, quarters + 4,
                       [&](const detail::QuadNode& quarter) { return cell_beyond(quarter, q, reach); });
}

}  // namespace

double QuadClosest::local(const Vec3d& q, SurfaceParameter at) const {
    const ControlMesh& mesh = patches_.mesh();
    double best = std::numeric_limits<double>::infinity();
    for (int step = 0; step < detail::k_newton_steps; ++step) {
        const SurfacePoint s = detail::with_derivatives(
            detail::RootShape::square, at.x, at.y, [&](double x, double y) { return patches_.frame(at.root, x, y); });
        const double distance = glm::length(q - s.position);
        if (distance >= best * (1 - 1e-9)) return std::min(best, distance);
        best = distance;
        double dx, dy;
        if (!detail::tangent_step(s, q, dx, dy)) return best;
        // No step longer than a cell: beyond the neighbour the linearisation means nothing.
        const double length = std::max(std::abs(dx), std::abs(dy));
        if (length > 0.5) dx *= 0.5 / length, dy *= 0.5 / length;
        double x = at.x + dx, y = at.y + dy;
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
        at.x = std::clamp(x, 0.0, 1.0);
        at.y = std::clamp(y, 0.0, 1.0);
    }
    return best;
}

double QuadClosest::in_cell(const Vec3d& q, HalfedgeId root, double best) const {
    const detail::QuadNode& node = patches_.root_node(root);
    if (cell_beyond(node, q, best + room_)) return best;
    return std::min(best,
                    detail::nearest_in_root(
                        detail::RootShape::square, q, [&](double x, double y) { return patches_.frame(root, x, y); },
                        [&](double x, double y) { return QuadPatches::position(node, x, y); }));
}

void QuadClosest::prepare(const RunContext& context) const {
    const ControlMesh& mesh = patches_.mesh();
    std::call_once(built_, [&] {
        const auto box_of = [&](std::uint32_t h) {
            return mesh.is_hole(mesh.face(HalfedgeId(h))) ? Box3d{} : patches_.with_root(HalfedgeId(h), node_box);
        };
        bvh_ = std::make_unique<ClosestBvh>(mesh.halfedge_count(), box_of, context);
        const Box3d bounds = bvh_->bounds();
        for (int k = 0; k < 3; ++k)
            room_ = std::max({room_, k_rounding * std::abs(bounds.lower[k]), k_rounding * std::abs(bounds.upper[k])});
    });
}

double QuadClosest::global(const Vec3d& q, double best) const {
    prepare({});
    const ClosestBvh::Hit hit =
        bvh_->query(q, best, [&](std::uint32_t h, double so_far) { return in_cell(q, HalfedgeId(h), so_far); });
    return hit.found() ? std::min(best, hit.distance) : best;
}

}  // namespace tetrakis
