#include "quad_cell_path.hpp"

#include <algorithm>
#include <bit>

namespace tetrakis::detail {

namespace {
constexpr std::uint32_t k_most_kept_roots = 2048;
}

QuadCellPath::QuadCellPath(const QuadPatches& patches)
    : patches_(patches),
      root_points_(std::bit_ceil(std::min(patches.mesh().halfedge_count() + 1, k_most_kept_roots))),
      cells_(k_max_level + k_max_refinement + 4),
      nets_(k_max_level + k_max_refinement + 4) {}

const CellPoints* QuadCellPath::root_points(const QuadNode& node, HalfedgeId root) {
    if (node.kind != QuadNode::Kind::regular || node.crease) return nullptr;
    RootPoints& kept = root_points_[root.value & (root_points_.size() - 1)];
    if (kept.root != root) {
        kept.root = root;
        kept.points = cell_points(node.net);
    }
    return &kept.points;
}

PathCell& QuadCellPath::cell(HalfedgeId root, int level, std::uint64_t x, std::uint64_t y) {
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
        top.forget();
        top.kept_ = root_points(*top.node, root);
        from = 0;
    }
    for (int l = from + 1; l <= level; ++l) {
        const PathCell& parent = cells_[static_cast<std::size_t>(l - 1)];
        PathCell& child = cells_[static_cast<std::size_t>(l)];
        child.x = x >> (level - l), child.y = y >> (level - l);
        child.forget();
        const int qx = static_cast<int>(child.x & 1), qy = static_cast<int>(child.y & 1);
        if (parent.irregular()) {
            child.node = parent.node->grown() + 2 * qy + qx;
            const bool regular = child.node->kind == QuadNode::Kind::regular;
            child.net = regular ? &child.node->net : nullptr;
            child.crease = regular ? child.node->crease : SideCrease{};
            child.kept_ = child.node->own_points;
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

const Vec3d& PathCell::point(int i) {
    const std::size_t at = static_cast<std::size_t>(i);
    const bool corner = i != k_centre_point && i % 2 == 0;
    if (irregular() && !(corner && node->kind == QuadNode::Kind::star)) return node->points()[at];
    if (smooth()) {
        if (kept_ == nullptr) {
            own_ = cell_points(*net);
            kept_ = &own_;
        }
        return (*kept_)[at];
    }
    if (!(known_ >> i & 1)) {
        known_ = static_cast<std::uint16_t>(known_ | 1 << i);
        own_[at] = irregular() ? node->corner(i / 3 == 0 ? i / 2 : 3 - i % 3 / 2)
                               : regular_position(*net, crease, 0.5 * (i % 3), 0.5 * (i / 3));
    }
    return own_[at];
}

}  // namespace tetrakis::detail
