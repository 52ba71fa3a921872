#include "quad_cell_walk.hpp"

#include <algorithm>
#include <bit>

namespace tetrakis::detail {

namespace {
constexpr std::uint32_t k_most_kept_roots = 2048;
}

QuadCellWalk::QuadCellWalk(const QuadPatches& patches)
    : patches_(patches),
      root_facts_(std::bit_ceil(std::min(patches.mesh().halfedge_count() + 1, k_most_kept_roots))),
      cells_(k_max_level + k_max_refinement + 4),
      nets_(k_max_level + k_max_refinement + 4) {}

const CellFacts* QuadCellWalk::root_facts(const QuadNode& node, HalfedgeId root) {
    if (node.kind != QuadNode::Kind::regular || node.crease) return nullptr;
    RootFacts& kept = root_facts_[root.value & (root_facts_.size() - 1)];
    if (kept.root != root) {
        kept.root = root;
        kept.facts.fill(node.net);
    }
    return &kept.facts;
}

WalkCell& QuadCellWalk::cell(HalfedgeId root, int level, std::uint64_t x, std::uint64_t y) {
    int from = -1;
    if (root == root_ && times_forgotten_ == patches_.times_forgotten()) {
        // The deepest kept cell that holds the wanted one.
        from = std::min(depth_, level);
        while (from > 0) {
            const WalkCell& kept = cells_[static_cast<std::size_t>(from)];
            if (kept.x == x >> (level - from) && kept.y == y >> (level - from)) break;
            --from;
        }
    }
    if (from < 0) {
        root_ = root;
        times_forgotten_ = patches_.times_forgotten();
        WalkCell& top = cells_[0];
        top.node = &patches_.root_node(root);
        const bool regular = top.node->kind == QuadNode::Kind::regular;
        top.net = regular ? &top.node->net : nullptr;
        top.crease = regular ? top.node->crease : SideCrease{};
        top.x = top.y = 0;
        top.forget();
        top.facts_ = root_facts(*top.node, root);
        from = 0;
    }
    for (int l = from + 1; l <= level; ++l) {
        const WalkCell& parent = cells_[static_cast<std::size_t>(l - 1)];
        WalkCell& child = cells_[static_cast<std::size_t>(l)];
        child.x = x >> (level - l), child.y = y >> (level - l);
        child.forget();
        const int qx = static_cast<int>(child.x & 1), qy = static_cast<int>(child.y & 1);
        if (parent.irregular()) {
            child.node = parent.node->grown() + 2 * qy + qx;
            const bool regular = child.node->kind == QuadNode::Kind::regular;
            child.net = regular ? &child.node->net : nullptr;
            child.crease = regular ? child.node->crease : SideCrease{};
            child.facts_ = child.node->facts;
        } else {
            child.node = nullptr;
            Net16& net = nets_[static_cast<std::size_t>(l)];
            if (parent.crease) {
                child_net(*parent.net, parent.crease, qx, qy, net, child.crease);
            } else {
                child_net(*parent.net, qx, qy, net);
                child.crease = {};
            }
            child.net = &net;
        }
    }
    depth_ = level;
    return cells_[static_cast<std::size_t>(level)];
}

double WalkCell::beyond() {
    if (!crease) return 0;
    if (!has_sharp_) {
        beyond_ = sharpened(*net, crease, sharp_);
        has_sharp_ = true;
    }
    return beyond_;
}

const WalkCell::Strips& WalkCell::strips() {
    if (strips_.count == 0) {
        strips_.count = crease_strips(*net, crease, strips_.strip);
        for (std::size_t i = 0; i < static_cast<std::size_t>(strips_.count); ++i)
            strips_.third[i] = ThirdBounds::of(strips_.strip[i].net);
    }
    return strips_;
}

WalkCell::Patch WalkCell::patch() {
    const double difference = beyond();
    const Net16* smooth_net = crease ? &sharp_ : net;
    if (!facts_) {
        if (!has_points_) own_.find_points(*smooth_net);
        own_.third = ThirdBounds::of(*smooth_net);
        facts_ = &own_;
    }
    return {smooth_net, facts_, difference};
}

const Vec3d& WalkCell::point(int i) {
    const std::size_t at = static_cast<std::size_t>(i);
    if (irregular()) return node->points()[at];
    if (!crease) {
        if (facts_) return facts_->point[at];
        if (!has_points_) own_.find_points(*net);
        has_points_ = true;
        return own_.point[at];
    }
    if (!(known_ >> i & 1)) {
        known_ = static_cast<std::uint16_t>(known_ | 1 << i);
        point_[at] = regular_position(*net, crease, 0.5 * (i % 3), 0.5 * (i / 3));
    }
    return point_[at];
}

}  // namespace tetrakis::detail
