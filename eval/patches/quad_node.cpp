#include "quad_node.hpp"

#include "quad_patches.hpp"

namespace tetrakis {

namespace detail {

namespace {

/// The net in the cell's frame, from that of a star whose corner `turn` is the origin.
void unturn_net(int turn, const Net16& net, Net16& out) {
    for (int b = -1; b <= 2; ++b)
        for (int a = -1; a <= 2; ++a) {
            const auto [x, y] = from_corner(turn, a, b);
            out.set(x, y, net.at(a, b));
        }
}

void grow_star(const QuadNode& node, QuadQuarters& quarters) {
    StarQuarters grown;
    subdivide(*node.star, quarters.star, grown);
    for (int k = 0; k < 4; ++k) {
        const int corner = (k + node.turn) & 3;
        QuadNode& quarter = quarters.cell[static_cast<std::size_t>(2 * k_corner_y[corner] + k_corner_x[corner])];
        if (k == 0 && node.star->valence != 4) {
            quarter.kind = QuadNode::Kind::star;
            quarter.turn = node.turn;
            quarter.star = &quarters.star;
        } else if (k == 2 && node.star->far_valence != 4) {
            quarter.turn = static_cast<std::uint8_t>(corner);
            quarter.adopt(std::make_unique<QuadStar>(std::move(grown.far)));
        } else {
            unturn_net(node.turn, grown.net[static_cast<std::size_t>(k)], quarter.net);
        }
    }
}

}  // namespace

Vec3d QuadNode::corner(int k) const {
    if (corners) return corners[3 * k_corner_y[k] + k_corner_x[k]];
    if (kind == Kind::regular) return regular_position(net, crease, k_corner_x[k], k_corner_y[k]);
    if (kind == Kind::star) return star->corner_limit((k - turn) & 3);
    return QuadPatches::corner_limit(*this, k).position;
}

/// The nine points of a cell from its quarters: of those that meet at a point the simplest one gives it.
void find_points(const QuadNode& node, QuadQuarters& quarters) {
    for (int i = 0; i < 9; ++i) {
        const int column = i % 3, row = i / 3;
        if (column != 1 && row != 1 && (node.corners || node.kind == QuadNode::Kind::star)) {
            quarters.point[static_cast<std::size_t>(i)] = node.corner(row == 0 ? column / 2 : 3 - column / 2);
            continue;
        }
        const QuadNode* best = nullptr;
        int corner = 0;
        for (int q = 0; q < 4; ++q) {
            const int x = column - (q & 1), y = row - (q >> 1);
            if (x < 0 || y < 0 || x > 1 || y > 1) continue;
            const QuadNode& quarter = quarters.cell[static_cast<std::size_t>(q)];
            if (best && quarter.kind >= best->kind) continue;
            best = &quarter;
            corner = y == 0 ? x : 3 - x;
        }
        quarters.point[static_cast<std::size_t>(i)] = best->corner(corner);
    }
    for (int q = 0; q < 4; ++q) {
        QuadNode& quarter = quarters.cell[static_cast<std::size_t>(q)];
        if (quarter.kind != QuadNode::Kind::regular) quarter.corners = &quarters.point[3u * (q >> 1) + (q & 1)];
    }
}

QuadNode::~QuadNode() { drop_quarters(); }

void QuadNode::drop_quarters() { delete quarters.exchange(nullptr, std::memory_order_acquire); }

void QuadNode::adopt(std::unique_ptr<QuadStar> from) {
    kind = Kind::star;
    own_star = std::move(from);
    star = own_star.get();
}

std::uint64_t QuadNode::own_bytes() const {
    return (own_star ? own_star->memory_bytes() : 0) + (rings ? rings->memory_bytes() : 0);
}

std::uint64_t QuadNode::grown_bytes() const {
    std::uint64_t sum = own_bytes();
    if (const QuadQuarters* below = quarters.load(std::memory_order_acquire)) {
        sum += sizeof(QuadQuarters) + below->star.points.outside_bytes();
        for (const QuadNode& child : below->cell) sum += child.grown_bytes();
    }
    return sum;
}

const QuadNode* QuadNode::grown() const {
    QuadNode* self = const_cast<QuadNode*>(this);
    if (const QuadQuarters* found = self->quarters.load(std::memory_order_acquire)) return found->cell.data();
    std::unique_ptr<QuadQuarters> fresh(new QuadQuarters);
    for (QuadNode& child : fresh->cell) {
        child.depth = static_cast<std::uint8_t>(depth + 1);
        child.bytes = bytes;
    }
    if (kind == Kind::star) {
        grow_star(*this, *fresh);
    } else {
        std::array<QuadRings, 4> children = rings->children();
        for (std::size_t k = 0; k < 4; ++k)
            classify(std::move(children[k]), fresh->cell[static_cast<std::size_t>(2 * k_corner_y[k] + k_corner_x[k])]);
    }
    find_points(*this, *fresh);
    std::uint64_t taken = sizeof(QuadQuarters) + fresh->star.points.outside_bytes();
    for (const QuadNode& child : fresh->cell) taken += child.own_bytes();
    QuadQuarters* expected = nullptr;
    if (!self->quarters.compare_exchange_strong(expected, fresh.get(), std::memory_order_acq_rel))
        return expected->cell.data();
    if (bytes) bytes->fetch_add(taken, std::memory_order_relaxed);
    return fresh.release()->cell.data();
}

const CellPoints& QuadNode::points() const {
    grown();
    return quarters.load(std::memory_order_acquire)->point;
}

}  // namespace detail

}  // namespace tetrakis
