#include "ghost_grid.hpp"

namespace tetrakis::detail {

std::vector<char> regular_corners(const RootNet& net) {
    const MeshLevel& base = net.base();
    const std::uint32_t regular = net.side_count() == 4 ? 4 : 6;
    std::vector<char> result(base.vertex_count, 0);
    for (std::uint32_t v = 0; v < base.vertex_count; ++v) {
        const std::uint32_t first = base.vertex_halfedge[v];
        if (first == RootNet::none) continue;
        std::uint32_t h = first, roots = 0;
        do {
            h = base.twin[base.prev(h)];
            ++roots;
        } while (h != RootNet::none && h != first);
        result[v] = h == first && roots == regular ? 1 : 0;
    }
    return result;
}

}  // namespace tetrakis::detail
