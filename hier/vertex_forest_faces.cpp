#include "tetrakis/hier/most_frequent.hpp"
#include "tetrakis/hier/vertex_forest.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace tetrakis {

VertexForest::Turn VertexForest::turn(std::uint32_t slot, int corner) const {
    const int side = (corner + 3) % 4;
    const Across next = across(slot, side);
    if (next.slot == k_boundary) return {k_boundary, 0, k_boundary, 0};
    const auto lead = [&](std::uint32_t cell, int at, std::uint32_t coarse, int coarse_side) {
        const std::uint32_t leaf = leaf_at(cell, at);
        return leaf == k_boundary ? Turn{k_boundary, 0, k_boundary, 0} : Turn{leaf, at, coarse, coarse_side};
    };
    if (next.slot != k_coarser) return lead(next.slot, next.side, k_boundary, 0);
    const Place place = outer(slot, side);
    const Across coarse = across(records_[record_of(place.slot)].parent, place.side);
    if (number(place.slot) == (place.side + 1) % 4) return {coarse.slot, coarse.side, k_boundary, 0};
    // In the middle of the coarser cell's side, and back across the other half.
    const Across half = beyond(slot, corner);
    return lead(half.slot, (half.side + 1) % 4, coarse.slot, coarse.side);
}

// The two ends of a crease of one edge meet on either side of it, and there is nothing between.
constexpr std::size_t k_least_corners = 3;

void VertexForest::add_leaves_around(LeafId leaf, int corner, std::vector<LeafId>& leaves) const {
    const std::size_t before = leaves.size();
    leaves.push_back(leaf);
    for (Turn at = turn(leaf.value, corner);; at = turn(at.slot, at.corner)) {
        if (at.slot == k_boundary) return leaves.resize(before);
        if (at.coarse != k_boundary) leaves.emplace_back(at.coarse);
        if (at.slot == leaf.value && at.corner == corner) break;
        leaves.emplace_back(at.slot);
    }
    if (leaves.size() - before < k_least_corners) leaves.resize(before);
}

namespace {

/// Whether a sibling of a lower number has that corner of a child, too: all but the parent's own corner, and what the
/// child shares with later ones.
constexpr bool meets_earlier_sibling(int child, int corner) {
    const int along = (corner - child + 4) % 4;
    return (along == 1 && child == 3) || (along >= 2 && child != 0);
}

}  // namespace

DualFaces VertexForest::faces(FaceCorners corners) const {
    const std::vector<LeafId> leaves = ordered_leaves();
    std::vector<std::uint32_t> rank(child_.size(), 0);
    for (std::size_t i = 0; i < leaves.size(); ++i) rank[leaves[i].value] = static_cast<std::uint32_t>(i);
    // The first of four siblings that are leaves: they meet in the middle.
    const auto is_whole_group = [&](std::uint32_t slot) {
        return !is_root(slot) && number(slot) == 0 && joint_of(slot) == nullptr && !is_split(slot + 1) &&
               !is_split(slot + 2) && !is_split(slot + 3);
    };
    const bool any_holes = std::find(roots_.hole.begin(), roots_.hole.end(), 1) != roots_.hole.end();
    std::vector<FaceId> hole_faces;
    for (std::uint32_t r = 0; any_holes && r < roots_.count(); ++r)
        if (roots_.hole[r] != 0) hole_faces.push_back(roots_.face[r]);
    std::sort(hole_faces.begin(), hole_faces.end());
    const auto is_hole = [&](FaceId f) { return std::binary_search(hole_faces.begin(), hole_faces.end(), f); };

    const bool any_creases = std::any_of(roots_.crease.begin(), roots_.crease.end(), [](auto c) { return c != 0; });
    const auto named = [&](std::uint32_t r) { return any_creases ? rank[vertex_leaf(leaves[r]).value] : r; };

    DualFaces out;
    out.face_offsets.reserve(leaves.size() + 1);
    out.face_vertices.reserve(4 * leaves.size());
    out.control_faces.reserve(leaves.size());
    out.diagonal_at_first.reserve(leaves.size());
    struct Meeting {
        std::uint32_t rank;
        int at;  // as DualFaces::Corner
    };
    std::vector<Meeting> around;  // the leaves that meet in a point
    std::vector<FaceId> homes;    // their control faces
    for (std::uint32_t i = 0; i < leaves.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            // The first of the corners that meet has the face; a coarser cell that has the point on its side has no
            // corner there.
            if (!is_root(leaves[i].value) && joint_of(leaves[i].value) == nullptr &&
                meets_earlier_sibling(number(leaves[i].value), c))
                continue;
            around.assign(1, {i, c});
            if (c == 2 && i + 3 < leaves.size() && is_whole_group(leaves[i].value)) {
                around.insert(around.end(), {{i + 1, 3}, {i + 2, 0}, {i + 3, 1}});
            } else {
                bool ours = true;
                for (Turn at = turn(leaves[i].value, c);; at = turn(at.slot, at.corner)) {
                    if (at.coarse != k_boundary)
                        around.push_back({rank[at.coarse], DualFaces::Corner::k_on_side + at.coarse_side});
                    if (at.slot == leaves[i].value && at.corner == c) break;
                    ours = at.slot != k_boundary && (rank[at.slot] != i ? rank[at.slot] > i : at.corner > c);
                    if (!ours) break;
                    around.push_back({rank[at.slot], at.corner});
                }
                if (!ours || around.size() < k_least_corners) continue;
            }
            homes.clear();
            for (const Meeting& m : around) {
                // Where it has the point on a side, two of its children would meet there: so all levels agree.
                const FaceId of = roots_.face[root_of(leaves[m.rank].value)];
                homes.insert(homes.end(), m.at < DualFaces::Corner::k_on_side ? 1 : 2, of);
            }
            const FaceId home = detail::most_frequent(homes);
            if (any_holes && is_hole(home)) continue;
            for (const Meeting& m : around) out.face_vertices.push_back(named(m.rank));
            if (corners == FaceCorners::leaves)
                for (const Meeting& m : around)
                    out.corners.push_back({leaves[m.rank], static_cast<std::uint8_t>(m.at)});
            out.face_offsets.push_back(static_cast<std::uint32_t>(out.face_vertices.size()));
            out.control_faces.push_back(home);
            // In the 4-8 pattern the diagonals of a level cross at every other point.
            const VertexCell cell = this->cell(leaves[i]);
            const std::uint32_t x = cell.at.x + (c == 1 || c == 2 ? 1 : 0), y = cell.at.y + (c >= 2 ? 1 : 0);
            out.diagonal_at_first.push_back((x + y + static_cast<std::uint32_t>(c)) % 2 == 0 ? 1 : 0);
        }
    constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
    // Leaves inside holes are in no face.
    std::vector<std::uint32_t> vertex(leaves.size(), unused);
    for (const std::uint32_t r : out.face_vertices) vertex[r] = 0;
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (vertex[i] == unused) continue;
        vertex[i] = static_cast<std::uint32_t>(out.leaves.size());
        out.leaves.push_back(leaves[i]);
        out.cells.push_back(cell(leaves[i]));
    }
    for (std::uint32_t& v : out.face_vertices) v = vertex[v];
    for (std::uint32_t i = 0; any_creases && i < leaves.size(); ++i)
        if (const std::uint32_t v = vertex[named(i)]; named(i) != i && v != unused)
            out.other_sides.push_back({v, leaves[i]});
    return out;
}

}  // namespace tetrakis
