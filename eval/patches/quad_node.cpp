#include "quad_node.hpp"

#include "../../schemes/core/sharpness.hpp"

namespace tetrakis::detail {

namespace {

/// The points at (-1, 0), (0, -1) and (-1, -1) as seen from a corner, with which the regular rules give what its ring's
/// rules give, at this level and below, on the cell's side; but for a crease of finite sharpness along one side.
/// Nothing if there are none. Beyond infinitely sharp sides p_-1 = 2 p_0 - p_1 makes the B-spline rules those of the
/// boundary.
std::optional<std::array<Vec3d, 3>> points_beyond(const CornerRing& ring) {
    const Vec3d& c = ring.centre;
    const auto e = [&](int i) { return ring.spoke(ring.cell + i).point; };
    const auto f = [&](int i) { return ring.spoke(ring.cell + i).face; };
    const auto sharpness = [&](int i) { return ring.spoke(ring.cell + i).sharpness; };
    if (ring.is_smooth() || !ring.is_stationary()) {
        if (ring.boundary || ring.size() != 4 || ring.sharpness != 0) return {};
        const int along = is_sharp(sharpness(0)) ? 0 : 1;
        // By Chaikin's method an edge's halves, and so the levels to come, depend on the next edges.
        const auto even = [&](int i) {
            const CornerRing::Spoke& s = ring.spoke(ring.cell + i);
            return !ring.chaikin || s.near_half == s.far_half;
        };
        const bool straight = sharpness(along) == sharpness(along + 2) && even(along) && even(along + 2) &&
                              sharpness(along + 1) == 0 && sharpness(along + 3) == 0;
        if (!straight) return {};
        return std::array{e(2), e(3), f(2)};
    }
    const auto sector = ring.sector();
    if (!sector || sector->faces != (sector->corner ? 1 : 2)) return {};
    if (sector->corner) return std::array{2.0 * c - e(0), 2.0 * c - e(1), 4.0 * c - 2.0 * (e(0) + e(1)) + f(0)};
    if (sector->first == ring.cell) return std::array{e(2), 2.0 * c - e(1), 2.0 * e(2) - f(1)};
    return std::array{2.0 * c - e(0), e(-1), 2.0 * e(-1) - f(-1)};
}

}  // namespace

SurfacePoint QuadShape::evaluate(const Patch& patch, const Point& at, bool second) {
    Weights4 wx[3], wy[3];
    regular_basis(patch.crease, at.x, at.y, wx, wy);
    const auto derivative = [&](int by_x, int by_y) { return combine(patch.net, wx[by_x], wy[by_y]); };
    SurfacePoint point{derivative(0, 0), derivative(1, 0), derivative(0, 1)};
    if (second) point.duu = derivative(2, 0), point.duv = derivative(1, 1), point.dvv = derivative(0, 2);
    return point;
}

bool QuadShape::find_patch(const CellRings<4>& rings, Patch& patch) {
    patch.crease = {};
    for (int k = 0; k < 4; ++k) {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>(k)];
        const auto beyond = points_beyond(ring);
        if (!beyond) return false;
        if (const float side = ring.spoke(ring.cell).sharpness; is_semi_sharp(side)) {
            if (patch.crease) return false;
            patch.crease = SideCrease{static_cast<std::int8_t>(k), side};
        }
        const auto put = [&](int dx, int dy, const Vec3d& p) {
            const auto [x, y] = from_corner(k, dx, dy);
            patch.net.set(x, y, p);
        };
        put(0, 0, ring.centre);
        put(-1, 0, (*beyond)[0]);
        put(0, -1, (*beyond)[1]);
        put(-1, -1, (*beyond)[2]);
    }
    return true;
}

std::unique_ptr<QuadStar> QuadShape::find_star(const CellRings<4>& rings, int& corner) {
    corner = -1;
    for (int k = 0; k < 4; ++k) {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>(k)];
        if (!ring.is_smooth() || (ring.size() != 4 && corner >= 0)) return nullptr;
        if (ring.size() != 4) corner = k;
    }
    if (corner < 0 || rings.corner[static_cast<std::size_t>(corner)].size() < 3) return nullptr;
    const auto around = [&](int k, int i) -> const CornerRing::Spoke& {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>((corner + k) & 3)];
        return ring.spoke(ring.cell + i);
    };
    const int n = rings.corner[static_cast<std::size_t>(corner)].size();
    auto star = std::make_unique_for_overwrite<QuadStar>();
    star->resize(n);
    Vec3d* out = star->points.data();
    *out++ = rings.corner[static_cast<std::size_t>(corner)].centre;
    for (int i = 0; i < n; ++i) *out++ = around(0, i).point, *out++ = around(0, i).face;
    // Seen from corner k + 1 at (1, 0): its axes are turned by a quarter; the outer points by its ring, and so on.
    *out++ = around(1, 2).face;   // (2, -1)
    *out++ = around(1, 3).point;  // (2, 0)
    *out++ = around(1, 3).face;   // (2, 1)
    *out++ = around(2, 2).face;   // (2, 2)
    *out++ = around(2, 3).point;  // (1, 2)
    *out++ = around(3, 2).point;  // (0, 2)
    *out++ = around(3, 2).face;   // (-1, 2)
    star->find_limit();
    return star;
}

void QuadShape::grow_star(const QuadStar& star, int turn, std::array<QuadNode, 4>& quarters) {
    std::array<QuadStar, 4> grown;
    subdivide(star, grown);
    for (int k = 0; k < 4; ++k) {
        QuadStar& part = grown[static_cast<std::size_t>(k)];
        const int corner = (k + turn) & 3;
        QuadNode& quarter = quarters[static_cast<std::size_t>(corner)];
        if (part.regular())
            quarter.patch.net = part.net(corner);
        else
            quarter.become(std::make_unique<QuadStar>(std::move(part)), corner);
    }
}

}  // namespace tetrakis::detail
