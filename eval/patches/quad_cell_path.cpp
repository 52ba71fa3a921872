#include "quad_cell_path.hpp"

#include <algorithm>

namespace tetrakis::detail {

QuadCellPath::QuadCellPath(const QuadPatches& patches)
    : patches_(patches), cells_(k_max_level + k_max_refinement + 4), nets_(k_max_level + k_max_refinement + 4) {}

const PathCell& QuadCellPath::cell(HalfedgeId root, int level, std::uint64_t x, std::uint64_t y) {
    int from = -1;
    if (root == root_ && times_forgotten_ == patches_.times_forgotten()) {
        // The deepest kept cell that holds the wanted one.
        from = std::min(depth_, level);
        while (from > 0) {
            const PathCell& kept = cells_[static_cast<std::size_t>(from)];
            if (kept.x == x >> (level - from) && kept.y == y >> (level - from)) break;
            --from;
        }
    }
    if (from < 0) {
        root_ = root;
        times_forgotten_ = patches_.times_forgotten();
        PathCell& top = cells_[0];
        top.node = &patches_.root_node(root);
        const bool regular = top.node->kind == QuadNode::Kind::regular;
        top.net = regular ? &top.node->net : nullptr;
        top.crease = regular ? top.node->crease : SideCrease{};
        top.x = top.y = 0;
        from = 0;
    }
    for (int l = from + 1; l <= level; ++l) {
        const PathCell& parent = cells_[static_cast<std::size_t>(l - 1)];
        PathCell& child = cells_[static_cast<std::size_t>(l)];
        child.x = x >> (level - l), child.y = y >> (level - l);
        const int qx = static_cast<int>(child.x & 1), qy = static_cast<int>(child.y & 1);
        if (parent.irregular()) {
            child.node = parent.node->grown() + 2 * qy + qx;
            const bool regular = child.node->kind == QuadNode::Kind::regular;
            child.net = regular ? &child.node->net : nullptr;
            child.crease = regular ? child.node->crease : SideCrease{};
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

Vec3d PathCell::point(int i) const {
    if (!irregular()) return regular_position(*net, crease, 0.5 * (i % 3), 0.5 * (i / 3));
    const bool corner = i != k_centre_point && i % 2 == 0;
    // A star's corners are known before it grows.
    if (corner && node->kind == QuadNode::Kind::star) return node->corner(i / 3 == 0 ? i / 2 : 3 - i % 3 / 2);
    return node->points()[static_cast<std::size_t>(i)];
}

}  // namespace tetrakis::detail
