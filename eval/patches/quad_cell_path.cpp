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
        cells_[0] = PathCell::of(patches_.root_node(root), 0, 0);
        from = 0;
    }
    for (int l = from + 1; l <= level; ++l) {
        const PathCell& parent = cells_[static_cast<std::size_t>(l - 1)];
        PathCell& child = cells_[static_cast<std::size_t>(l)];
        const std::uint64_t child_x = x >> (level - l), child_y = y >> (level - l);
        const int qx = static_cast<int>(child_x & 1), qy = static_cast<int>(child_y & 1);
        if (parent.irregular()) {
            child = PathCell::of(parent.node->grown()[quad_quarter(qx, qy)], child_x, child_y);
            continue;
        }
        Net16& net = nets_[static_cast<std::size_t>(l)];
        child = {nullptr, &net, {}, child_x, child_y};
        child_net(*parent.net, parent.crease, qx, qy, net, child.crease);
    }
    depth_ = level;
    return cells_[static_cast<std::size_t>(level)];
}

}  // namespace tetrakis::detail
