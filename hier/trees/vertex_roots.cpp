#include "vertex_roots.hpp"

#include <algorithm>

namespace tetrakis {

std::vector<Site> cell_sites(std::span<const VertexCell> cells) {
    std::vector<Site> sites(cells.size());
    std::transform(cells.begin(), cells.end(), sites.begin(), cell_site);
    return sites;
}

VertexRoots::Across VertexRoots::across(const VertexCell& cell, int side) const {
    const std::uint32_t end = (1u << cell.level) - 1;
    Across next{Across::Kind::neighbour, cell, (side + 2) % 4};
    const auto [x, y] = cell.at;
    if (side == 0 ? y > 0 : side == 1 ? x < end : side == 2 ? y < end : x > 0) {
        next.cell.at.x += side == 1 ? 1u : side == 3 ? ~0u : 0u;
        next.cell.at.y += side == 2 ? 1u : side == 0 ? ~0u : 0u;
        return next;
    }
    const std::uint32_t to = link[4 * std::size_t{cell.root} + static_cast<std::size_t>(side)];
    if (to == outside) return {Across::Kind::outside, {}, 0};
    if ((crease[cell.root] >> side & 1) != 0) next.kind = Across::Kind::other_side_of_crease;
    // A side runs from corner to corner; seen from the cell across it, its direction is reversed.
    const std::uint32_t from_end = side == 0 ? end - x : side == 1 ? end - y : side == 2 ? x : y;
    next.cell.root = to / 4;
    next.side = static_cast<int>(to % 4);
    next.cell.at = next.side == 0   ? LatticePoint{from_end, 0}
                   : next.side == 1 ? LatticePoint{end, from_end}
                   : next.side == 2 ? LatticePoint{end - from_end, end}
                                    : LatticePoint{0, end - from_end};
    return next;
}

std::vector<VertexCell> VertexRoots::sides(const VertexCell& cell) const {
    std::vector<VertexCell> found{cell};
    for (std::size_t i = 0; i < found.size(); ++i)
        for (int side = 0; crease[found[i].root] != 0 && side < 4; ++side) {
            const Across other = across(found[i], side);
            if (other.kind == Across::Kind::other_side_of_crease &&
                std::find(found.begin(), found.end(), other.cell) == found.end())
                found.push_back(other.cell);
        }
    return found;
}

VertexRoots::Fan VertexRoots::fan(const Corner& corner) const {
    Fan fan;
    for (Corner at = corner;;) {
        fan.corners.push_back(at);
        const Across next = across(at.cell, (at.corner + 3) % 4);
        if (next.kind != Across::Kind::neighbour) break;
        at = {next.cell, next.side};
        if (at == corner) return fan;
    }
    fan.closed = false;
    std::vector<Corner> before;
    for (Corner at = corner;;) {
        const Across next = across(at.cell, at.corner);
        if (next.kind != Across::Kind::neighbour) break;
        before.push_back(at = {next.cell, (next.side + 1) % 4});
    }
    fan.corners.insert(fan.corners.begin(), before.rbegin(), before.rend());
    return fan;
}

}  // namespace tetrakis
