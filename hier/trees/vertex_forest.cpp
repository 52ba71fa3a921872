#include "vertex_forest.hpp"

#include "../base/memory.hpp"
#include "../base/most_frequent.hpp"
#include "tree_forest_change.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace tetrakis {

template class TreeForest<DualCells>;

VertexForest::VertexForest(VertexRoots roots) : TreeForest(DualCells{std::move(roots)}) {}

LeafId VertexForest::vertex_leaf(LeafId leaf) const {
    LeafId first = leaf;
    for_each_other_side(leaf.value, [&](std::uint32_t slot) {
        if (root_of(slot) < root_of(first.value)) first = LeafId(slot);
    });
    return first;
}

void VertexForest::add_other_sides(LeafId leaf, std::vector<LeafId>& leaves) const {
    for_each_other_side(leaf.value, [&](std::uint32_t slot) { leaves.emplace_back(slot); });
}

// Faces.

VertexForest::Turn VertexForest::turn(std::uint32_t slot, int corner) const {
    const int side = (corner + 3) % 4;
    const Across next = across(slot, side);
    if (next.slot == k_boundary) return {k_boundary, 0, k_boundary, 0};
    if (next.slot != k_coarser) return {leaf_at(next.slot, next.side), next.side, k_boundary, 0};
    const Across coarse = across(records_[record_of(slot)].parent, side);
    if (number(slot) == (side + 1) % 4) return {coarse.slot, coarse.side, k_boundary, 0};
    // The point is in the middle of the coarser cell's side: continue across the side's other half.
    const Across half = beyond(slot, corner);
    const int at = (half.side + 1) % 4;
    return {leaf_at(half.slot, at), at, coarse.slot, coarse.side};
}

// Where the two ends of a crease of one edge meet, there is no face.
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

/// Whether an earlier sibling has the same corner. This is so for all corners but the parent's own one and those that
/// the child shares with later siblings.
constexpr bool meets_earlier_sibling(int child, int corner) {
    const int along = (corner - child + 4) % 4;
    return (along == 1 && child == 3) || (along >= 2 && child != 0);
}

}  // namespace

// Each face is found at the first corner that meets there. Its vertices are ranks of leaves until all faces are known.
DualFaces VertexForest::faces(FaceCorners corners) const {
    const VertexRoots& roots = rule_.roots;
    const std::vector<LeafId> leaves = ordered_leaves();
    detail::PoolVector<std::uint32_t> rank(child_.size(), 0);  // per slot
    for (std::size_t i = 0; i < leaves.size(); ++i) rank[leaves[i].value] = static_cast<std::uint32_t>(i);
    std::vector<FaceId> hole_faces;
    for (std::uint32_t r = 0; r < roots.count(); ++r)
        if (roots.hole[r] != 0) hole_faces.push_back(roots.face[r]);
    std::sort(hole_faces.begin(), hole_faces.end());
    const bool any_creases = std::ranges::any_of(roots.crease, [](auto c) { return c != 0; });
    // The rank of the leaf that represents a leaf's vertex.
    const auto named = [&](std::uint32_t r) { return any_creases ? rank[vertex_leaf(leaves[r]).value] : r; };

    struct Meeting {
        std::uint32_t rank;  // rank of a leaf at a point where leaves meet
        int at;              // as in DualFaces::Corner
    };
    std::vector<Meeting> around;
    // Whether a corner is the first one at its point, and the point has a face. A coarser cell with the point on its
    // side has no corner there.
    const auto has_face = [&](std::uint32_t i, int c) {
        const std::uint32_t slot = leaves[i].value;
        if (!is_root(slot) && meets_earlier_sibling(number(slot), c)) return false;
        around.assign(1, {i, c});
        for (Turn at = turn(slot, c);; at = turn(at.slot, at.corner)) {
            if (at.coarse != k_boundary)
                around.push_back({rank[at.coarse], DualFaces::Corner::k_on_side + at.coarse_side});
            if (at.slot == slot && at.corner == c) break;
            if (at.slot == k_boundary) return false;
            if (rank[at.slot] != i ? rank[at.slot] < i : at.corner < c) return false;
            around.push_back({rank[at.slot], at.corner});
        }
        return around.size() >= k_least_corners;
    };
    DualFaces out;
    detail::reserve_large(out.face_offsets, leaves.size() + 1);
    detail::reserve_large(out.face_vertices, 4 * leaves.size());
    detail::reserve_large(out.control_faces, leaves.size());
    detail::reserve_large(out.diagonal_at_first, leaves.size());
    std::vector<FaceId> homes;  // control faces of the leaves that meet
    for (std::uint32_t i = 0; i < leaves.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            if (!has_face(i, c)) continue;
            homes.clear();
            for (const Meeting& m : around) {
                // A leaf with the point on a side counts twice, as two of its children would: so all levels agree.
                const FaceId of = roots.face[root_of(leaves[m.rank].value)];
                homes.insert(homes.end(), m.at < DualFaces::Corner::k_on_side ? 1 : 2, of);
            }
            const FaceId home = detail::most_frequent(homes);
            if (std::binary_search(hole_faces.begin(), hole_faces.end(), home)) continue;
            for (const Meeting& m : around) out.face_vertices.push_back(named(m.rank));
            if (corners == FaceCorners::leaves)
                for (const Meeting& m : around)
                    out.corners.push_back({leaves[m.rank], static_cast<std::uint8_t>(m.at)});
            out.face_offsets.push_back(static_cast<std::uint32_t>(out.face_vertices.size()));
            out.control_faces.push_back(home);
            // In the 4-8 pattern the diagonals of a level meet at every other point.
            const VertexCell cell = this->cell(leaves[i]);
            const std::uint32_t x = cell.at.x + (c == 1 || c == 2 ? 1 : 0), y = cell.at.y + (c >= 2 ? 1 : 0);
            out.diagonal_at_first.push_back((x + y + static_cast<std::uint32_t>(c)) % 2 == 0 ? 1 : 0);
        }

    constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();
    // Leaves inside holes are in no face.
    detail::PoolVector<std::uint32_t> vertex(leaves.size(), unused);
    for (const std::uint32_t r : out.face_vertices) vertex[r] = 0;
    detail::reserve_large(out.leaves, leaves.size());
    detail::reserve_large(out.cells, leaves.size());
    for (std::size_t i = 0; i < leaves.size(); ++i) {
        if (vertex[i] == unused) continue;
        vertex[i] = static_cast<std::uint32_t>(out.leaves.size());
        out.leaves.push_back(leaves[i]);
        out.cells.push_back(cell(leaves[i]));
    }
    if (out.leaves.size() < leaves.size())
        for (std::uint32_t& v : out.face_vertices) v = vertex[v];
    for (std::uint32_t i = 0; any_creases && i < leaves.size(); ++i) {
        const std::uint32_t first = named(i), v = vertex[first];
        if (first != i && v != unused) out.other_sides.push_back({v, leaves[i]});
    }
    return out;
}

}  // namespace tetrakis
