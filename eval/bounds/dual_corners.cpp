#include "dual_corners.hpp"

#include <algorithm>

namespace tetrakis::detail {

namespace {

using Member = DualCorners::Member;

constexpr std::size_t k_regular = 4;
// Along a boundary or crease two cells meet in a point, at a corner of it there is one. Where a crease ends there are
// those of its last vertex' two sides and that of the vertex ahead.
constexpr std::size_t k_around_an_end = 3;

/// Across a side of a root; false where the surface ends or a crease runs.
bool cross(const VertexRoots& roots, std::uint32_t root, int side, std::uint32_t& next, int& its_side) {
    const std::uint32_t link = roots.link[4 * std::size_t{root} + static_cast<std::size_t>(side)];
    if (link == VertexRoots::outside || (roots.crease[root] >> side & 1) != 0) return false;
    next = link / 4;
    its_side = static_cast<int>(link % 4);
    return true;
}

DualCorners::Point point_around(const VertexRoots& roots, const Member& start) {
    DualCorners::Point point;
    point.around.push_back(start);
    for (Member at = start;;) {
        Member next{};
        if (!cross(roots, at.root, (at.corner + 3) % 4, next.root, next.corner)) break;
        if (next.root == start.root && next.corner == start.corner) return point;
        point.around.push_back(at = next);
    }
    point.closed = false;
    for (Member at = start;;) {
        Member next{};
        int side = 0;
        if (!cross(roots, at.root, at.corner, next.root, side)) return point;
        next.corner = (side + 1) % 4;
        point.around.insert(point.around.begin(), at = next);
    }
}

}  // namespace

DualCorners::DualCorners(const VertexRoots& roots) : point_(4 * std::size_t{roots.count()}, none) {
    std::vector<std::uint8_t> seen(point_.size(), 0);
    for (std::uint32_t r = 0; r < roots.count(); ++r)
        for (int c = 0; c < 4; ++c) {
            if (seen[4 * std::size_t{r} + index(c)] != 0) continue;
            Point point = point_around(roots, {r, c});
            const bool regular =
                point.closed ? point.around.size() == k_regular : point.around.size() < k_around_an_end;
            for (const Member& m : point.around) {
                seen[4 * std::size_t{m.root} + index(m.corner)] = 1;
                if (!regular)
                    point_[4 * std::size_t{m.root} + index(m.corner)] = static_cast<std::uint32_t>(points_.size());
            }
            if (!regular) points_.push_back(std::move(point));
        }
}

int DualCorners::corner_of(const VertexCell& cell) const {
    const std::uint32_t last = (1u << cell.level) - 1;
    for (int c = 0; c < 4; ++c)
        if (cell.at.x == (c == 1 || c == 2 ? last : 0) && cell.at.y == (c >= 2 ? last : 0) &&
            point(cell.root, c) != none)
            return c;
    return -1;
}

}  // namespace tetrakis::detail
