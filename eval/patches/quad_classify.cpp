#include "quad_node.hpp"

#include <bitset>

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

CornerKind corner_kind(const QuadLocalMesh& mesh, int corner, const CornerFan& fan) {
    CornerKind kind;
    const std::pmr::vector<float> sharp = fan_sharpness(mesh, fan);
    const std::size_t edges = sharp.size();
    const float own = mesh.corner_sharpness[static_cast<std::size_t>(corner)];
    std::size_t infinite = 0, finite = 0;
    for (float s : sharp) {
        if (s == k_sharpness_infinity)
            ++infinite;
        else if (s > 0)
            ++finite;
    }
    const std::size_t out = fan.cell_index, in = fan.boundary ? out + 1 : (out + 1) % edges;
    kind.valence = static_cast<int>(fan.faces());
    kind.out_sharp = sharp[out] > 0;
    kind.in_sharp = sharp[in] > 0;
    if (infinite == 0 && finite == 0 && own == 0) {
        kind.type = fan.boundary ? CornerKind::other : CornerKind::smooth;
        return kind;
    }
    if (finite > 0) {
        // A crease of one finite sharpness that runs straight through a regular vertex, along one side of the cell.
        const bool straight =
            infinite == 0 && finite == 2 && own == 0 && !fan.boundary && edges == 4 && kind.out_sharp != kind.in_sharp;
        if (!straight) return kind;
        const std::size_t first = kind.out_sharp ? out : in, opposite = (first + 2) % 4;
        if (sharp[opposite] != sharp[first]) return kind;
        kind.type = CornerKind::semi_crease;
        kind.sharpness = sharp[first];
        return kind;
    }
    if (own != 0 && own != k_sharpness_infinity) return kind;
    const bool corner_rule = own != 0 || infinite >= 3;
    if (corner_rule && kind.out_sharp && kind.in_sharp) {
        kind.type = CornerKind::sharp_corner;
        return kind;
    }
    if (corner_rule || infinite != 2 || kind.out_sharp == kind.in_sharp) return kind;
    // The sector between the two sharp edges must have two faces: the cell and the one beyond its smooth side.
    const std::size_t far = kind.out_sharp ? in + 1 : out + edges - 1;
    const std::size_t other_edge = fan.boundary ? (kind.out_sharp ? in + 1 : out - 1) : far % edges;
    if (other_edge < edges && sharp[other_edge] == k_sharpness_infinity) kind.type = CornerKind::inside_crease;
    return kind;
}

bool regular_net(const QuadLocalMesh& mesh, const std::array<CornerFan, 4>& fans,
                 const std::array<CornerKind, 4>& kinds, QuadNode& node) {
    bool infinite_side[4], semi_side[4];
    for (int k = 0; k < 4; ++k) {
        const float s = mesh.sharpness[static_cast<std::size_t>(k)];
        infinite_side[k] = s == k_sharpness_infinity;
        semi_side[k] = s > 0 && !infinite_side[k];
    }
    SideCrease crease;
    for (int k = 0; k < 4; ++k) {
        const CornerKind& kind = kinds[static_cast<std::size_t>(k)];
        if (kind.type == CornerKind::other) return false;
        if (kind.type == CornerKind::smooth && kind.valence != 4) return false;
        if (semi_side[k]) {
            const CornerKind& end = kinds[static_cast<std::size_t>((k + 1) & 3)];
            if (crease || kind.type != CornerKind::semi_crease || end.type != CornerKind::semi_crease) return false;
            if (kind.sharpness != end.sharpness || kind.sharpness != mesh.sharpness[static_cast<std::size_t>(k)])
                return false;
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
        const CornerFan& fan = fans[static_cast<std::size_t>(k)];
        const int edges = static_cast<int>(fan.edges()), faces = static_cast<int>(fan.faces());
        const int home = static_cast<int>(fan.cell_index);
        const auto put_ring = [&](int dx, int dy, int index, bool face) {
            const int count = face ? faces : edges;
            if (fan.boundary && (index < 0 || index >= count)) return;
            while (index < 0) index += count;
            while (index >= count) index -= count;
            const auto i = static_cast<std::size_t>(index);
            const auto [x, y] = from_corner(k, dx, dy);
            put(x, y, face ? fan_face(mesh, fan, i) : fan_edge(mesh, fan, i));
        };
        put(k_corner_x[k], k_corner_y[k], mesh.points[mesh.faces[0][static_cast<std::size_t>(k)]]);
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

bool star_net(const QuadLocalMesh& mesh, const std::array<CornerFan, 4>& fans, const std::array<CornerKind, 4>& kinds,
              QuadNode& node) {
    int special = -1;
    for (int k = 0; k < 4; ++k) {
        if (kinds[static_cast<std::size_t>(k)].type != CornerKind::smooth) return false;
        if (kinds[static_cast<std::size_t>(k)].valence == 4) continue;
        if (special >= 0) return false;
        special = k;
    }
    if (special < 0) return false;
    auto star = std::make_unique<QuadStar>();
    const CornerFan& fan = fans[static_cast<std::size_t>(special)];
    const std::pmr::vector<Vec3d> ring = fan_ring(mesh, fan);
    const std::size_t n = fan.faces();
    star->resize(static_cast<int>(n));
    star->points[0] = ring[0];
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t j = (i + fan.cell_index) % n;
        star->points[1 + 2 * i] = ring[1 + 2 * j];
        star->points[2 + 2 * i] = ring[2 + 2 * j];
    }
    Vec3d* outer = star->points.data() + 2 * n + 1;
    const auto around = [&](int corner, int edge_or_face, bool face) {
        const std::size_t k = static_cast<std::size_t>((special + corner) & 3);
        const std::size_t index = (fans[k].cell_index + static_cast<std::size_t>(edge_or_face)) % 4;
        return face ? fan_face(mesh, fans[k], index) : fan_edge(mesh, fans[k], index);
    };
    // Seen from corner k + 1 at (1, 0): its axes are turned by a quarter; the outer points by its ring, and so on.
    outer[0] = around(1, 2, true);   // (2, -1)
    outer[1] = around(1, 3, false);  // (2, 0)
    outer[2] = around(1, 3, true);   // (2, 1)
    outer[3] = around(2, 2, true);   // (2, 2)
    outer[4] = around(2, 3, false);  // (1, 2)
    outer[5] = around(3, 2, false);  // (0, 2)
    outer[6] = around(3, 2, true);   // (-1, 2)
    node.turn = static_cast<std::uint8_t>(special);
    star->find_limit();
    node.adopt(std::move(star));
    return true;
}

}  // namespace

void classify(const QuadLocalMesh& mesh, QuadNode& node) {
    std::pmr::memory_resource* memory = mesh.points.get_allocator().resource();
    const std::array<CornerFan, 4> fans{corner_fan(mesh, 0, memory), corner_fan(mesh, 1, memory),
                                        corner_fan(mesh, 2, memory), corner_fan(mesh, 3, memory)};
    std::array<CornerKind, 4> kinds;
    for (int k = 0; k < 4; ++k)
        kinds[static_cast<std::size_t>(k)] = corner_kind(mesh, k, fans[static_cast<std::size_t>(k)]);
    if (regular_net(mesh, fans, kinds, node) || star_net(mesh, fans, kinds, node)) return;
    node.kind = QuadNode::Kind::generic;
    node.local = std::make_unique<QuadLocalMesh>(mesh, pool_resource());
}

}  // namespace tetrakis::detail
