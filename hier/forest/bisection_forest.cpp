#include "bisection_forest.hpp"

#include "../base/error.hpp"
#include "../base/parallel.hpp"
#include "corner_cell.hpp"

#include <algorithm>
#include <cassert>
#include <string>
#include <utility>

namespace tetrakis {

BisectionForest::BisectionForest(const ControlMesh& mesh) : mesh_(&mesh) {
    const std::uint64_t points = std::uint64_t{mesh.vertex_count()} + mesh.face_count();
    if (points >= PointId::none)
        throw Error(ErrorCode::memory_limit, "a mesh with " + std::to_string(mesh.vertex_count()) + " vertices and " +
                                                 std::to_string(mesh.face_count()) +
                                                 " faces has more points than can be numbered; split it");
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (!mesh.is_hole(FaceId(f))) root_count_ += mesh.face_size(FaceId(f));
    leaf_capacity_ = root_count_;
    clear();
}

void BisectionForest::clear() {
    const ControlMesh& mesh = *mesh_;
    leaves_.resize(mesh.halfedge_count());
    sites_.resize(fixed_points());
    leaf_count_ = root_count_;
    midpoint_count_ = 0;
    free_leaf_ = {};
    free_point_ = {};
    const auto surface_leaf = [&](HalfedgeId h) {
        return h.valid() && !mesh.is_hole(mesh.face(h)) ? LeafId(h.value) : LeafId{};
    };
    for_each_index(mesh.halfedge_count(), [&](std::uint32_t i) {
        const HalfedgeId h(i);
        const BisectionShape shape = BisectionShape::root();
        const FaceId f = mesh.face(h);
        leaves_[i] = {.path = 0,
                      .cell = h,
                      .apex = shape.apex,
                      .neighbour = {surface_leaf(mesh.twin(h)), LeafId(mesh.next(h).value), LeafId(mesh.prev(h).value)},
                      .vertex = {vertex_point(mesh.origin(h)), vertex_point(mesh.target(h)), centre_point(f)},
                      .depth = mesh.is_hole(f) ? k_dead : std::uint8_t{0},
                      .direction = shape.direction,
                      .mark = 0};
    });
    for_each_index(mesh.vertex_count(), [&](std::uint32_t v) {
        const HalfedgeId h = mesh.vertex_halfedge(VertexId(v));
        sites_[v] = h.valid() ? canonical(mesh, {h, {0, 0}, 0}) : Site{};
    });
    for_each_index(mesh.face_count(), [&](std::uint32_t f) {
        sites_[mesh.vertex_count() + f] = {mesh.face_halfedge(FaceId(f)), {1, 1}, 0};
    });
}

std::uint64_t BisectionForest::memory_bytes() const {
    return leaves_.capacity() * sizeof(BisectionLeaf) + sites_.capacity() * sizeof(Site);
}

void BisectionForest::shrink() {
    leaves_.shrink_to_fit();
    sites_.shrink_to_fit();
    leaf_capacity_ = leaf_slots() - hole_slots();
    midpoint_capacity_ = point_slots() - fixed_points();
}

void BisectionForest::reserve(std::uint64_t leaves, std::uint64_t midpoints) {
    const std::uint64_t slots = leaves + hole_slots(), points = midpoints + fixed_points();
    if (slots >= LeafId::none || points >= PointId::none)
        throw Error(ErrorCode::memory_limit,
                    "the refinement would have more than 2^32 - 1 leaves; use a larger tolerance or a lower level");
    leaves_.reserve(static_cast<std::size_t>(slots));
    sites_.reserve(static_cast<std::size_t>(points));
    leaf_capacity_ = std::max(leaf_capacity_, static_cast<std::uint32_t>(leaves));
    midpoint_capacity_ = std::max(midpoint_capacity_, static_cast<std::uint32_t>(midpoints));
}

void BisectionForest::map_room() {
    detail::map_at_once(leaves_, leaves_.capacity());
    detail::map_at_once(sites_, sites_.capacity());
}

void BisectionForest::require_splittable(LeafId id) const {
    assert(is_leaf(id));
    if (depth(id) == k_max_bisection_depth)
        throw Error(ErrorCode::unsupported, "leaf " + std::to_string(id.value) + " is at the largest depth, " +
                                                std::to_string(k_max_bisection_depth) +
                                                "; the tolerance is out of reach here");
}

BisectionForest::SplitCost BisectionForest::split_cost(LeafId id) const {
    require_splittable(id);
    SplitCost cost;
    for (LeafId at = id; at.valid(); at = coarser_base(at)) {
        cost.leaves += leaves_[at.value].neighbour[0].valid() ? 2 : 1;
        ++cost.midpoints;
    }
    return cost;
}

LeafId BisectionForest::take_leaf() {
    ++leaf_count_;
    if (!free_leaf_.valid()) {
        leaves_.resize(leaves_.size() + 1);
        return LeafId(leaf_slots() - 1);
    }
    const LeafId slot = free_leaf_;
    take_free_leaf(slot);
    return slot;
}

void BisectionForest::free_leaf(LeafId slot) {
    leaves_[slot.value].neighbour = {free_leaf_, LeafId{}, LeafId{}};
    if (free_leaf_.valid()) leaves_[free_leaf_.value].neighbour[1] = slot;
    free_leaf_ = slot;
}

void BisectionForest::take_free_leaf(LeafId slot) {
    const auto [before, after, none] = leaves_[slot.value].neighbour;
    if (before.valid()) leaves_[before.value].neighbour[1] = after;
    (after.valid() ? leaves_[after.value].neighbour[0] : free_leaf_) = before;
}

void BisectionForest::move_leaf(LeafId from, LeafId to) {
    take_free_leaf(to);
    leaves_[to.value] = leaves_[from.value];
    for (const LeafId beside : leaves_[to.value].neighbour)
        if (beside.valid()) std::ranges::replace(leaves_[beside.value].neighbour, from, to);
    leaves_[from.value].depth = k_dead;
    leaves_.resize(from.value);
}

void BisectionForest::drop_last_slots() {
    while (leaf_slots() > mesh_->halfedge_count() && leaves_[leaf_slots() - 1].depth == k_dead) {
        take_free_leaf(LeafId(leaf_slots() - 1));
        leaves_.resize(leaf_slots() - 1);
    }
}

PointId BisectionForest::take_point(const Site& site) {
    ++midpoint_count_;
    PointId point = free_point_;
    if (point.valid()) {
        free_point_.value = sites_[point.value].at.x;
    } else {
        sites_.resize(sites_.size() + 1);
        point.value = point_slots() - 1;
    }
    sites_[point.value] = site;
    return point;
}

// Makes the leaf's link to `from` lead to `to`; an invalid leaf is ignored.
void BisectionForest::relink(LeafId leaf, LeafId from, LeafId to) {
    if (!leaf.valid()) return;
    auto& neighbour = leaves_[leaf.value].neighbour;
    neighbour[neighbour[0] == from ? 0 : neighbour[1] == from ? 1 : 2] = to;
}

// Splits the leaf and its neighbour across the base, if any. Both have the same depth, and there is room.
Diamond BisectionForest::bisect(LeafId id) {
    const LeafId across = leaves_[id.value].neighbour[0];
    Diamond diamond;
    diamond.pair_count = across.valid() ? 2 : 1;
    diamond.pairs[0] = {std::min(id, across), take_leaf()};
    if (across.valid()) diamond.pairs[1] = {std::max(id, across), take_leaf()};
    const BisectionLeaf& first = leaves_[diamond.pairs[0][0].value];
    diamond.midpoint =
        take_point(canonical(*mesh_, {first.cell, first.shape().middle(first.depth), lattice_level(first.depth + 1)}));
    for (std::uint32_t i = 0; i < diamond.pair_count; ++i) {
        const auto [slot0, slot1] = diamond.pairs[i];
        const auto [other0, other1] = diamond.pairs[1 - i];
        BisectionLeaf &child0 = leaves_[slot0.value], &child1 = leaves_[slot1.value];
        const BisectionShape shape = child0.shape();
        const int depth = child0.depth;
        const auto [a, b, apex] = child0.vertex;
        const auto [base, across1, across2] = child0.neighbour;
        relink(across1, slot0, slot1);
        child1.path = child0.path << 1 | 1;
        child1.cell = depth == 0 ? mesh_->next(child0.cell) : child0.cell;
        child1.neighbour = {across1, slot0, other0};
        child1.vertex = {b, apex, diamond.midpoint};
        child1.mark = 0;
        child0.path <<= 1;
        child0.neighbour = {across2, other1, slot1};
        child0.vertex = {apex, a, diamond.midpoint};
        const auto put_shape = [&](BisectionLeaf& child, int bit) {
            const BisectionShape part = shape.child(depth, bit);
            child.apex = part.apex;
            child.direction = part.direction;
            child.depth = static_cast<std::uint8_t>(depth + 1);
        };
        put_shape(child0, 0);
        put_shape(child1, 1);
    }
    return diamond;
}

// Undoes bisect(), together with free_folded().
void BisectionForest::fold_diamond(const Diamond& diamond) {
    for (std::uint32_t i = diamond.pair_count; i-- > 0;) {
        const auto [slot0, slot1] = diamond.pairs[i];
        BisectionLeaf &child0 = leaves_[slot0.value], &child1 = leaves_[slot1.value];
        const BisectionShape shape = child0.shape().parent(child0.depth, 0);
        relink(child1.neighbour[0], slot1, slot0);
        child0.path >>= 1;
        child0.apex = shape.apex;
        child0.direction = shape.direction;
        child0.neighbour = {diamond.pairs[1 - i][0], child1.neighbour[0], child0.neighbour[0]};
        child0.vertex = {child0.vertex[1], child1.vertex[0], child0.vertex[0]};
        --child0.depth;
        child0.mark = child1.mark = 0;
        child1.depth = k_dead;
    }
}

void BisectionForest::free_folded(const Diamond& diamond) {
    for (std::uint32_t i = diamond.pair_count; i-- > 0;) free_leaf(diamond.pairs[i][1]);
    Site& site = sites_[diamond.midpoint.value];
    site = {};
    site.at.x = std::exchange(free_point_, diamond.midpoint).value;
    leaf_count_ -= diamond.pair_count;
    --midpoint_count_;
}

// The diamond of a leaf. It has no pairs if the leaf is a root, or if another leaf at its apex is split further.
Diamond BisectionForest::find_diamond(LeafId id) const {
    const BisectionLeaf& leaf = leaves_[id.value];
    Diamond diamond{.midpoint = leaf.vertex[2]};
    // A neighbour across an inner edge of the diamond is part of the diamond if it has the same depth.
    const auto add_pair = [&](LeafId child0, LeafId child1) {
        if (!child0.valid() || !child1.valid()) return false;
        if (depth(child0) != leaf.depth || depth(child1) != leaf.depth) return false;
        if (leaves_[child0.value].neighbour[2] != child1) return false;
        diamond.pairs[diamond.pair_count++] = {child0, child1};
        return true;
    };
    const bool is_child1 = (leaf.path & 1) != 0;
    const LeafId child0 = is_child1 ? leaf.neighbour[1] : id, child1 = is_child1 ? id : leaf.neighbour[2];
    if (leaf.depth == 0 || !add_pair(child0, child1)) return {};
    const LeafId other1 = leaves_[child0.value].neighbour[1], other0 = leaves_[child1.value].neighbour[2];
    if ((other0.valid() || other1.valid()) && !add_pair(other0, other1)) return {};
    if (diamond.pair_count == 2 && diamond.pairs[1][0] < diamond.pairs[0][0])
        std::swap(diamond.pairs[0], diamond.pairs[1]);
    return diamond;
}

CellTriangle cell_triangle(const ControlMesh& mesh, HalfedgeId root, int depth, std::uint64_t path) {
    BisectionShape shape = BisectionShape::root();
    for (int d = 0; d < depth; ++d) shape = shape.child(d, static_cast<int>((path >> (depth - 1 - d)) & 1));
    // The corner cell: Q(root), or Q(next root) where the first split went to child 1.
    return shape.in(depth > 0 && ((path >> (depth - 1)) & 1) != 0 ? mesh.next(root) : root, depth);
}

Site corner_site(const ControlMesh& mesh, const CellTriangle& triangle, std::size_t k) {
    const std::uint32_t n = 1u << triangle.level;
    CellPoint p{triangle.root, triangle.corner[k].x, triangle.corner[k].y};
    if (p.x > n) p = cross(mesh, p, CellSide::next_cell, n);
    const LatticePoint at{static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y)};
    return canonical(mesh, {p.root, at, triangle.level});
}

}  // namespace tetrakis
