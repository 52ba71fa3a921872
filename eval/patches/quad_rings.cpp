#include "quad_rings.hpp"

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/sharpness.hpp"
#include "quad_node.hpp"

#include <bitset>
#include <utility>

namespace tetrakis::detail {

namespace {

/// What a corner of a cell looks like from the cell.
struct CornerKind {
    enum Type { smooth, inside_crease, sharp_corner, semi_crease, other } type = other;
    int valence = 0;         ///< smooth: number of faces
    bool out_sharp = false;  ///< the cell's side that leaves this corner counter-clockwise is sharp
    bool in_sharp = false;   ///< and the side that arrives at it
    float sharpness = 0;     ///< semi_crease
};

CornerKind corner_kind(const CornerRing& ring) {
    CornerKind kind;
    const float own = ring.sharpness;
    const auto sharp = [&](int i) { return ring.spoke(i).sharpness; };
    int infinite = 0, finite = 0;
    for (const CornerRing::Spoke& s : ring.spokes) {
        infinite += s.sharpness == k_sharpness_infinity;
        finite += is_semi_sharp(s.sharpness);
    }
    const int out = ring.cell, in = ring.cell + 1;
    kind.valence = ring.faces();
    kind.out_sharp = sharp(out) > 0;
    kind.in_sharp = sharp(in) > 0;
    if (infinite == 0 && finite == 0 && own == 0) {
        kind.type = ring.boundary ? CornerKind::other : CornerKind::smooth;
        return kind;
    }
    if (finite > 0) {
        // A crease of one finite sharpness that runs straight through a regular vertex, along one side of the cell.
        const bool straight = infinite == 0 && finite == 2 && own == 0 && !ring.boundary && ring.size() == 4 &&
                              kind.out_sharp != kind.in_sharp;
        const int first = kind.out_sharp ? out : in;
        if (!straight || sharp(first + 2) != sharp(first)) return kind;
        kind.type = CornerKind::semi_crease;
        kind.sharpness = sharp(first);
        return kind;
    }
    if (is_semi_sharp(own)) return kind;
    const bool corner_rule = own != 0 || infinite >= 3;
    if (corner_rule && kind.out_sharp && kind.in_sharp) {
        kind.type = CornerKind::sharp_corner;
        return kind;
    }
    if (corner_rule || infinite != 2 || kind.out_sharp == kind.in_sharp) return kind;
    // The sector between the two sharp edges must have two faces: the cell and the one beyond its smooth side.
    const int far = kind.out_sharp ? in + 1 : out - 1;
    const bool is_there = !ring.boundary || (far >= 0 && far < ring.size());
    if (is_there && sharp(far) == k_sharpness_infinity) kind.type = CornerKind::inside_crease;
    return kind;
}

bool regular_net(const QuadRings& rings, const std::array<CornerKind, 4>& kinds, QuadNode& node) {
    bool infinite_side[4], semi_side[4];
    float sharpness[4];  // of the sides
    for (int k = 0; k < 4; ++k) {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>(k)];
        sharpness[k] = ring.spoke(ring.cell).sharpness;
        infinite_side[k] = sharpness[k] == k_sharpness_infinity;
        semi_side[k] = is_semi_sharp(sharpness[k]);
    }
    SideCrease crease;
    for (int k = 0; k < 4; ++k) {
        const CornerKind& kind = kinds[static_cast<std::size_t>(k)];
        if (kind.type == CornerKind::other) return false;
        if (kind.type == CornerKind::smooth && kind.valence != 4) return false;
        if (semi_side[k]) {
            const CornerKind& end = kinds[static_cast<std::size_t>((k + 1) & 3)];
            if (crease || kind.type != CornerKind::semi_crease || end.type != CornerKind::semi_crease) return false;
            if (kind.sharpness != end.sharpness || kind.sharpness != sharpness[k]) return false;
            crease = SideCrease{static_cast<std::int8_t>(k), kind.sharpness};
        }
    }
    std::bitset<16> known;
    const auto put = [&](int x, int y, const Vec3d& p) {
        node.net.set(x, y, p);
        known.set(static_cast<std::size_t>(4 * (y + 1) + x + 1));
    };
    const auto is_known = [&](int x, int y) { return known.test(static_cast<std::size_t>(4 * (y + 1) + x + 1)); };
    for (int k = 0; k < 4; ++k) {
        const CornerRing& ring = rings.corner[static_cast<std::size_t>(k)];
        const int home = ring.cell;
        const auto put_ring = [&](int dx, int dy, int index, bool face) {
            if (ring.boundary && (index < 0 || index >= (face ? ring.faces() : ring.size()))) return;
            const auto [x, y] = from_corner(k, dx, dy);
            put(x, y, face ? ring.spoke(index).face : ring.spoke(index).point);
        };
        put(k_corner_x[k], k_corner_y[k], ring.centre);
        const bool out_open = !infinite_side[k], in_open = !infinite_side[(k + 3) & 3];
        if (in_open) {
            put_ring(-1, 1, home + 1, true);
            put_ring(-1, 0, home + 2, false);
        }
        if (out_open) {
            put_ring(1, -1, home - 1, true);
            put_ring(0, -1, home - 1, false);
        }
        if (in_open && out_open) put_ring(-1, -1, home + 2, true);
    }
    // Phantom points beyond infinitely sharp sides: p_-1 = 2 p_0 - p_1 makes the B-spline rules those of the boundary.
    for (int pass = 0; pass < 2; ++pass) {
        for (int i = -1; i <= 2; ++i) {
            if (infinite_side[3] && !is_known(-1, i) && is_known(0, i) && is_known(1, i))
                put(-1, i, 2.0 * node.net.at(0, i) - node.net.at(1, i));
            if (infinite_side[1] && !is_known(2, i) && is_known(1, i) && is_known(0, i))
                put(2, i, 2.0 * node.net.at(1, i) - node.net.at(0, i));
        }
        for (int i = -1; i <= 2; ++i) {
            if (infinite_side[0] && !is_known(i, -1) && is_known(i, 0) && is_known(i, 1))
                put(i, -1, 2.0 * node.net.at(i, 0) - node.net.at(i, 1));
            if (infinite_side[2] && !is_known(i, 2) && is_known(i, 1) && is_known(i, 0))
                put(i, 2, 2.0 * node.net.at(i, 1) - node.net.at(i, 0));
        }
    }
    if (!known.all()) return false;
    node.kind = QuadNode::Kind::regular;
    node.crease = crease;
    return true;
}

bool star_net(const QuadRings& rings, const std::array<CornerKind, 4>& kinds, QuadNode& node) {
    int special = -1;
    for (int k = 0; k < 4; ++k) {
        if (kinds[static_cast<std::size_t>(k)].type != CornerKind::smooth) return false;
        if (kinds[static_cast<std::size_t>(k)].valence == 4) continue;
        if (special >= 0) return false;
        special = k;
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
    node.turn = static_cast<std::uint8_t>(special);
    star->find_limit();
    node.adopt(std::move(star));
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
    std::array<CornerKind, 4> kinds;
    for (std::size_t k = 0; k < 4; ++k) kinds[k] = corner_kind(rings.corner[k]);
    if (regular_net(rings, kinds, node) || star_net(rings, kinds, node)) return;
    node.kind = QuadNode::Kind::generic;
    node.rings = std::make_unique<QuadRings>(std::move(rings));
}

}  // namespace tetrakis::detail
