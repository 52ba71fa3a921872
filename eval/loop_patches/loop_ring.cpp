#include "loop_ring.hpp"

#include <utility>

namespace tetrakis::detail {

namespace {

/// Six neighbours, counter-clockwise from the cell's next corner, with which the regular rules give what this ring's
/// rules give, at this level and below, on the cell's side; empty if there are none. Across a boundary or crease with
/// three triangles on the cell's side the missing neighbours are reflected: c + p_0 - p_1; at a corner with a single
/// triangle, through the centre too.
std::optional<std::array<Vec3d, 6>> regular_neighbours(const CornerRing& ring) {
    const int cell = ring.cell;
    const Vec3d& centre = ring.centre;
    std::array<Vec3d, 6> out;
    if (ring.is_smooth()) {
        if (ring.size() != 6) return {};
        for (int i = 0; i < 6; ++i) out[i] = ring.spoke(cell + i).point;
        return out;
    }
    const auto sector = ring.sector();
    if (!ring.is_stationary() || !sector) return {};
    const auto [first, faces, corner] = *sector;
    const int offset = cell - first;
    const auto p = [&ring, first = first](int i) { return ring.spoke(first + i).point; };
    if (!corner && faces == 3) {
        const std::array<Vec3d, 6> around{p(0), p(1), p(2), p(3), centre + p(3) - p(2), centre + p(0) - p(1)};
        for (int i = 0; i < 6; ++i) out[i] = around[(i + offset) % 6];
        return out;
    }
    if (corner && faces == 1)
        return std::array<Vec3d, 6>{
            p(0), p(1), centre + p(1) - p(0), 2.0 * centre - p(0), 2.0 * centre - p(1), centre + p(0) - p(1)};
    return {};
}

}  // namespace

std::array<LoopRings, 4> LoopRings::children() const {
    std::array<LoopRings, 4> out;
    const std::array<CornerRing, 3> child{corner[0].child(), corner[1].child(), corner[2].child()};
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        out[k].corner[k] = child[k];
        CornerRing middle = side_ring(corner[k], corner[next], child[k], child[next]);
        middle.cell = 2;
        out[k].corner[next] = middle;
        middle.cell = 0;
        out[next].corner[k] = middle;
        middle.cell = 1;
        out[3].corner[(k + 2) % 3] = std::move(middle);
    }
    return out;
}

std::optional<Net12> LoopRings::regular_net() const {
    const auto a = regular_neighbours(corner[0]);
    if (!a) return {};
    const auto b = regular_neighbours(corner[1]);
    if (!b) return {};
    const auto c = regular_neighbours(corner[2]);
    if (!c) return {};
    return Net12{corner[0].centre, corner[1].centre, corner[2].centre, (*a)[2], (*a)[3], (*a)[4],
                 (*a)[5],          (*b)[3],          (*b)[4],          (*b)[5], (*c)[3], (*c)[4]};
}

int LoopRings::star_corner() const {
    for (int k = 0; k < 3; ++k)
        if (corner[k].is_smooth() && corner[k].size() != 6)
            return regular_neighbours(corner[(k + 1) % 3]) && regular_neighbours(corner[(k + 2) % 3]) ? k : -1;
    return -1;
}

std::vector<Vec3d> LoopRings::star_points(int k) const {
    const CornerRing& centre = corner[k];
    std::vector<Vec3d> out{centre.centre};
    for (int i = 0; i < centre.size(); ++i) out.push_back(centre.spoke(centre.cell + i).point);
    const auto a = *regular_neighbours(corner[(k + 1) % 3]);
    const auto b = *regular_neighbours(corner[(k + 2) % 3]);
    out.insert(out.end(), {a[3], a[4], a[5], b[3], b[4]});
    return out;
}

std::vector<Vec3d> LoopRings::points() const {
    std::vector<Vec3d> out;
    for (const CornerRing& ring : corner) ring.add_points(out);
    return out;
}

}  // namespace tetrakis::detail
