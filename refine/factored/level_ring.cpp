#include "level_ring.hpp"

#include "../../schemes/core/sharpness.hpp"

namespace tetrakis::detail {

namespace {

constexpr std::uint32_t none = MeshLevel::none;

/// Sharpness of the half of edge e at the end that half-edge h of it starts from, one level on.
float child_at(const MeshLevel& level, CreaseMethod method, std::uint32_t h, LevelRing& scratch) {
    const float s = level.edge_sharpness[level.edge(h)];
    if (method == CreaseMethod::uniform || !is_semi_sharp(s)) return child_sharpness(s);
    scratch.gather(level, method, level.origin[h]);
    return child_sharpness_chaikin(s, scratch.sharpness);
}

}  // namespace

void LevelRing::gather(const MeshLevel& level, CreaseMethod method, std::uint32_t v) {
    halfedges.clear();
    neighbours.clear();
    sharpness.clear();
    boundary = false;
    const std::uint32_t start = level.vertex_halfedge[v];
    std::uint32_t h = start;
    do {
        halfedges.push_back(h);
        neighbours.push_back(level.origin[level.next(h)]);
        sharpness.push_back(level.edge_sharpness[level.edge(h)]);
        const std::uint32_t before = level.prev(h);
        h = level.twin[before];
        if (h == none) {
            boundary = true;
            neighbours.push_back(level.origin[before]);
            sharpness.push_back(level.edge_sharpness[level.edge(before)]);
        }
    } while (h != start && h != none);
    child.resize(sharpness.size());
    for (std::size_t i = 0; i < child.size(); ++i)
        child[i] = method == CreaseMethod::uniform ? child_sharpness(sharpness[i])
                                                   : child_sharpness_chaikin(sharpness[i], sharpness);
}

double crease_weight(const MeshLevel& level, CreaseMethod method, std::uint32_t e, LevelRing& scratch) {
    const float s = level.edge_sharpness[e];
    if (!is_semi_sharp(s)) return is_sharp(s) ? 1 : 0;
    if (method == CreaseMethod::uniform) return edge_crease_weight(s, child_sharpness(s), child_sharpness(s));
    // At the far end the edge is seen from the vertex itself: any half-edge that starts there knows its ring.
    const std::uint32_t h = level.edge_halfedge[e];
    const float near = child_at(level, method, h, scratch);
    scratch.gather(level, method, level.origin[level.next(h)]);
    return edge_crease_weight(s, near, child_sharpness_chaikin(s, scratch.sharpness));
}

}  // namespace tetrakis::detail
