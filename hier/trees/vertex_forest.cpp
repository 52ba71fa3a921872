#include "vertex_forest.hpp"

#include "../base/memory.hpp"
#include "../base/most_frequent.hpp"
#include "../base/parallel.hpp"
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
    // In the middle of the coarser cell's side, and back across the other half.
    const Across half = beyond(slot, corner);
    const int at = (half.side + 1) % 4;
    return {leaf_at(half.slot, at), at, coarse.slot, coarse.side};
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

/// The faces at the corners of some leaves, with ranks for vertices.
struct VertexForest::FaceList {
    std::vector<std::uint32_t> sizes, vertices;  // per face; and the ranks of their leaves
    std::vector<FaceId> control_faces;
    std::vector<std::uint8_t> diagonal_at_first;
    std::vector<DualFaces::Corner> corners;
};

/// Finds the faces of all leaves, each at the first of the corners that meet there.
class VertexForest::FaceFinder {
  public:
    FaceFinder(const VertexForest& forest, FaceCorners corners)
        : forest_(forest),
          roots_(forest.rule_.roots),
          with_corners_(corners == FaceCorners::leaves),
          leaves_(forest.ordered_leaves()),
          rank_(forest.child_.size(), 0),
          any_holes_(std::find(roots_.hole.begin(), roots_.hole.end(), 1) != roots_.hole.end()),
          any_creases_(std::any_of(roots_.crease.begin(), roots_.crease.end(), [](auto c) { return c != 0; })) {
        for (std::size_t i = 0; i < leaves_.size(); ++i) rank_[leaves_[i].value] = static_cast<std::uint32_t>(i);
        for (std::uint32_t r = 0; any_holes_ && r < roots_.count(); ++r)
            if (roots_.hole[r] != 0) hole_faces_.push_back(roots_.face[r]);
        std::sort(hole_faces_.begin(), hole_faces_.end());
    }

    const std::vector<LeafId>& leaves() const { return leaves_; }
    bool any_creases() const { return any_creases_; }
    /// The rank that stands for a leaf's vertex.
    std::uint32_t named(std::uint32_t r) const {
        return any_creases_ ? rank_[forest_.vertex_leaf(leaves_[r]).value] : r;
    }

    void find(std::uint32_t begin, std::uint32_t end, FaceList& out) const {
        std::vector<Meeting> around;
        std::vector<FaceId> homes;  // their control faces
        for (std::uint32_t i = begin; i < end; ++i)
            for (int c = 0; c < 4; ++c) {
                if (!has_face(i, c, around)) continue;
                homes.clear();
                for (const Meeting& m : around) {
                    // Where it has the point on a side, two of its children would meet there: so all levels agree.
                    const FaceId of = roots_.face[forest_.root_of(leaves_[m.rank].value)];
                    homes.insert(homes.end(), m.at < DualFaces::Corner::k_on_side ? 1 : 2, of);
                }
                const FaceId home = detail::most_frequent(homes);
                if (any_holes_ && std::binary_search(hole_faces_.begin(), hole_faces_.end(), home)) continue;
                for (const Meeting& m : around) out.vertices.push_back(named(m.rank));
                if (with_corners_)
                    for (const Meeting& m : around)
                        out.corners.push_back({leaves_[m.rank], static_cast<std::uint8_t>(m.at)});
                out.sizes.push_back(static_cast<std::uint32_t>(around.size()));
                out.control_faces.push_back(home);
                // In the 4-8 pattern the diagonals of a level cross at every other point.
                const VertexCell cell = forest_.cell(leaves_[i]);
                const std::uint32_t x = cell.at.x + (c == 1 || c == 2 ? 1 : 0), y = cell.at.y + (c >= 2 ? 1 : 0);
                out.diagonal_at_first.push_back((x + y + static_cast<std::uint32_t>(c)) % 2 == 0 ? 1 : 0);
            }
    }

  private:
    /// A leaf at a point where leaves meet.
    struct Meeting {
        std::uint32_t rank;
        int at;  // as DualFaces::Corner
    };

    /// Whether the corner is the first of those that meet, and has the face; a coarser cell that has the point on its
    /// side has no corner there.
    bool has_face(std::uint32_t i, int c, std::vector<Meeting>& around) const {
        const std::uint32_t slot = leaves_[i].value;
        if (!forest_.is_root(slot) && meets_earlier_sibling(forest_.number(slot), c)) return false;
        around.assign(1, {i, c});
        for (Turn at = forest_.turn(slot, c);; at = forest_.turn(at.slot, at.corner)) {
            if (at.coarse != k_boundary)
                around.push_back({rank_[at.coarse], DualFaces::Corner::k_on_side + at.coarse_side});
            if (at.slot == slot && at.corner == c) break;
            if (at.slot == k_boundary) return false;
            if (rank_[at.slot] != i ? rank_[at.slot] < i : at.corner < c) return false;
            around.push_back({rank_[at.slot], at.corner});
        }
        return around.size() >= k_least_corners;
    }

    const VertexForest& forest_;
    const VertexRoots& roots_;
    bool with_corners_;
    std::vector<LeafId> leaves_;
    detail::PoolVector<std::uint32_t> rank_;  // per slot
    bool any_holes_, any_creases_;
    std::vector<FaceId> hole_faces_;
};

DualFaces VertexForest::faces(FaceCorners corners) const {
    const FaceFinder finder(*this, corners);
    const std::vector<LeafId>& leaves = finder.leaves();
    const auto leaf_count = static_cast<std::uint32_t>(leaves.size());
    // Parts of the leaves, whose faces follow each other. One thread needs no parts.
    constexpr std::uint32_t k_leaves_per_part = 1u << 14;
    const std::uint32_t part_count = detail::one_thread() ? 1 : leaf_count / k_leaves_per_part + 1;
    std::vector<FaceList> parts(part_count);
    for_each_index(
        part_count,
        [&](std::uint32_t p) {
            const auto bound = [&](std::uint64_t n) { return static_cast<std::uint32_t>(n * leaf_count / part_count); };
            const std::uint32_t begin = bound(p), end = bound(p + 1), count = end - begin;
            FaceList& part = parts[p];
            detail::reserve_large(part.vertices, 4 * std::size_t{count});
            detail::reserve_large(part.sizes, count);
            detail::reserve_large(part.control_faces, count);
            detail::reserve_large(part.diagonal_at_first, count);
            finder.find(begin, end, part);
        },
        1);
    DualFaces out;
    std::size_t face_count = 0;
    for (const FaceList& part : parts) face_count += part.sizes.size();
    detail::reserve_large(out.face_offsets, face_count + 1);
    for (FaceList& part : parts)
        for (const std::uint32_t size : part.sizes) out.face_offsets.push_back(out.face_offsets.back() + size);
    const auto join = [&](auto FaceList::*from, auto& to, std::size_t size) {
        if (part_count == 1) {
            to = std::move(parts[0].*from);
            return;
        }
        detail::reserve_large(to, size);
        for (FaceList& part : parts) {
            to.insert(to.end(), (part.*from).begin(), (part.*from).end());
            part.*from = {};
        }
    };
    join(&FaceList::vertices, out.face_vertices, out.face_offsets.back());
    join(&FaceList::control_faces, out.control_faces, face_count);
    join(&FaceList::diagonal_at_first, out.diagonal_at_first, face_count);
    join(&FaceList::corners, out.corners, corners == FaceCorners::leaves ? out.face_offsets.back() : 0);

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
    for (std::uint32_t i = 0; finder.any_creases() && i < leaf_count; ++i) {
        const std::uint32_t named = finder.named(i), v = vertex[named];
        if (named != i && v != unused) out.other_sides.push_back({v, leaves[i]});
    }
    return out;
}

}  // namespace tetrakis
