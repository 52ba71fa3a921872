#include "quad_rings.hpp"

#include "../../schemes/core/sharpness.hpp"
#include "quad_node.hpp"

#include <optional>
#include <utility>

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

bool regular_net(const QuadRings& rings, QuadNode& node) {
    SideCrease crease;
    for (int k = 0; k < 4; ++k) {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>(k)];
        const auto beyond = points_beyond(ring);
        if (!beyond) return false;
        if (const float side = ring.spoke(ring.cell).sharpness; is_semi_sharp(side)) {
            if (crease) return false;
            crease = SideCrease{static_cast<std::int8_t>(k), side};
        }
        const auto put = [&](int dx, int dy, const Vec3d& p) {
            const auto [x, y] = from_corner(k, dx, dy);
            node.net.set(x, y, p);
        };
        put(0, 0, ring.centre);
        put(-1, 0, (*beyond)[0]);
        put(0, -1, (*beyond)[1]);
        put(-1, -1, (*beyond)[2]);
    }
    node.kind = QuadNode::Kind::regular;
    node.crease = crease;
    return true;
}

bool star_net(const QuadRings& rings, QuadNode& node) {
    int special = -1;
    for (int k = 0; k < 4; ++k) {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>(k)];
        if (!ring.is_smooth() || (ring.size() != 4 && special >= 0)) return false;
        if (ring.size() != 4) special = k;
    }
    if (special < 0) return false;
    const auto around = [&](int corner, int i) -> const CornerRing::Spoke& {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>((special + corner) & 3)];
        return ring.spoke(ring.cell + i);
    };
    const int n = rings.corner[static_cast<std::size_t>(special)].size();
    auto star = std::make_unique<QuadStar>();
    star->resize(n);
    Vec3d* out = star->points.data();
    *out++ = rings.corner[static_cast<std::size_t>(special)].centre;
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
    node.adopt(std::move(star), special);
    return true;
}

}  // namespace

std::array<QuadRings, 4> QuadRings::children() const {
    std::array<QuadRings, 4> out;
    const std::array<CornerRing, 4> child{corner[0].child(), corner[1].child(), corner[2].child(), corner[3].child()};
    CornerRing centre;
    centre.scheme = SchemeKind::catmull_clark;
    centre.chaikin = corner[0].chaikin;
    centre.centre = corner[0].face_point(corner[0].cell);
    for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t next = (k + 1) & 3;
        centre.spokes.push_back({corner[k].edge_point(corner[k].cell), child[next].centre});
        CornerRing middle = side_ring(corner[k], corner[next], child[k], child[next]);
        middle.cell = 1;
        out[k].corner[next] = middle;
        middle.cell = 0;
        out[next].corner[k] = std::move(middle);
    }
    for (std::size_t k = 0; k < 4; ++k) {
        centre.cell = static_cast<int>((k + 3) & 3);
        out[k].corner[(k + 2) & 3] = centre;
        out[k].corner[k] = child[k];
    }
    return out;
}

std::vector<Vec3d> QuadRings::points() const {
    std::vector<Vec3d> out;
    for (const CornerRing& ring : corner) ring.add_points(out);
    return out;
}

std::size_t QuadRings::memory_bytes() const {
    std::size_t bytes = sizeof(QuadRings);
    for (const CornerRing& ring : corner) bytes += ring.spokes.capacity() * sizeof(CornerRing::Spoke);
    return bytes;
}

void classify(QuadRings rings, QuadNode& node) {
    if (regular_net(rings, node) || star_net(rings, node)) return;
    node.adopt(std::make_unique<QuadRings>(std::move(rings)));
}

}  // namespace tetrakis::detail
