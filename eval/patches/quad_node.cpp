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
            quarter.become(quarters.star, node.turn);
        } else if (k == 2 && node.star->far_valence != 4) {
            quarter.adopt(std::make_unique<QuadStar>(std::move(grown.far)), corner);
        } else {
            unturn_net(node.turn, grown.net[static_cast<std::size_t>(k)], quarter.net);
        }
    }
}

}  // namespace

Vec3d QuadNode::corner(int k) const {
    return kind == Kind::regular ? regular_position(net, crease, k_corner_x[k], k_corner_y[k])
                                 : net.at(k_corner_x[k], k_corner_y[k]);
}

QuadNode::~QuadNode() { drop_quarters(); }

void QuadNode::drop_quarters() { delete quarters.exchange(nullptr, std::memory_order_acquire); }

void QuadNode::become(const QuadStar& of, int corner) {
    kind = Kind::star;
    turn = static_cast<std::uint8_t>(corner);
    star = &of;
    for (int k = 0; k < 4; ++k) net.set(k_corner_x[k], k_corner_y[k], of.corner_limit((k - corner) & 3));
}

void QuadNode::adopt(std::unique_ptr<QuadStar> from, int corner) {
    own_star = std::move(from);
    become(*own_star, corner);
}

void QuadNode::adopt(std::unique_ptr<QuadRings> from) {
    kind = Kind::generic;
    rings = std::move(from);
    for (int k = 0; k < 4; ++k)
        net.set(k_corner_x[k], k_corner_y[k], rings->corner[static_cast<std::size_t>(k)].limit().position);
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
    std::uint64_t taken = sizeof(QuadQuarters) + fresh->star.points.outside_bytes();
    for (const QuadNode& child : fresh->cell) taken += child.own_bytes();
    QuadQuarters* expected = nullptr;
    if (!self->quarters.compare_exchange_strong(expected, fresh.get(), std::memory_order_acq_rel))
        return expected->cell.data();
    if (bytes) bytes->fetch_add(taken, std::memory_order_relaxed);
    return fresh.release()->cell.data();
}

}  // namespace detail

}  // namespace tetrakis
