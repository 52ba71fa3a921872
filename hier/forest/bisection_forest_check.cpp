#include "bisection_forest.hpp"

#include <string>

namespace tetrakis {

std::optional<std::string> BisectionForest::check_leaf(std::uint32_t slot) const {
    const BisectionLeaf& l = leaves_[slot];
    const auto fault = [&](const std::string& what) { return "leaf " + std::to_string(slot) + ": " + what; };
    if (l.depth > k_max_bisection_depth) return fault("depth " + std::to_string(l.depth));
    if (l.cell.value >= mesh_->halfedge_count()) return fault("its corner cell does not exist");
    if (l.mark != 0) return fault("it has kept the mark of a batch");
    if (l.depth < 64 && l.path >> l.depth != 0) return fault("its path is longer than its depth");
    const CellTriangle t = triangle(LeafId(slot));
    const CellTriangle expected = cell_triangle(*mesh_, root(LeafId(slot)), l.depth, l.path);
    if (t.root != expected.root || t.level != expected.level || t.corner != expected.corner)
        return fault("its shape is not that of its path");
    if (mesh_->is_hole(mesh_->face(l.cell))) return fault("it lies in a hole");
    for (std::size_t k = 0; k < 3; ++k) {
        const std::string edge = "edge " + std::to_string(k);
        if (!is_point(l.vertex[k])) return fault("corner " + std::to_string(k) + " is no point");
        if (corner_site(*mesh_, t, k) != sites_[l.vertex[k].value])
            return fault("corner " + std::to_string(k) + " is not at its point's site");
        const LeafId across = l.neighbour[k];
        if (!across.valid()) {
            // Open edges lie on control edges that are boundary or lead to a hole.
            const LatticePoint p = t.corner[k], q = t.corner[(k + 1) % 3];
            const HalfedgeId h = p.y == 0 && q.y == 0   ? t.root
                                 : p.x == 0 && q.x == 0 ? mesh_->prev(t.root)
                                                        : HalfedgeId{};
            if (!h.valid()) return fault(edge + " is open inside a face");
            if (mesh_->twin(h).valid() && !mesh_->is_hole(mesh_->face(mesh_->twin(h))))
                return fault(edge + " is open, but its control edge is not");
            continue;
        }
        if (!is_leaf(across)) return fault(edge + " leads to a slot without leaf");
        const BisectionLeaf& o = leaves_[across.value];
        std::size_t back = 3;
        for (std::size_t j = 0; j < 3; ++j)
            if (o.neighbour[j].value == slot) {
                if (back != 3) return fault("two edges lead to leaf " + std::to_string(across.value));
                back = j;
            }
        if (back == 3) return fault(edge + " is not linked back");
        if (o.vertex[back] != l.vertex[(k + 1) % 3] || o.vertex[(back + 1) % 3] != l.vertex[k])
            return fault(edge + " has other end points seen from beyond");
        // Base meets base at one depth, leg 1 meets leg 2 at one depth, a leg meets the base of a finer leaf.
        const int step = (k == 0 ? -1 : 0) + (back == 0 ? 1 : 0);
        if (o.depth - l.depth != step) return fault(edge + " leads to a leaf of the wrong depth");
        if (k != 0 && back != 0 && k == back) return fault(edge + " meets the same leg");
    }
    return std::nullopt;
}

std::optional<std::string> BisectionForest::check_pool() const {
    const std::uint32_t fixed_points = this->fixed_points();
    std::uint32_t leaves = 0, midpoints = 0, hole_slots = 0;
    std::vector<std::uint64_t> covered(mesh_->halfedge_count(), 0);
    std::vector<std::uint8_t> used(sites_.size(), 0);
    for (std::uint32_t s = 0; s < leaf_slots(); ++s) {
        const BisectionLeaf& l = leaves_[s];
        if (l.depth == k_dead) {
            hole_slots += s < mesh_->halfedge_count();
            continue;
        }
        ++leaves;
        covered[root(LeafId(s)).value] += std::uint64_t{1} << (k_max_bisection_depth - l.depth);
        for (PointId p : l.vertex) used[p.value] = 1;
    }
    if (leaves != leaf_count_)
        return "the leaf count is " + std::to_string(leaf_count_) + ", not " + std::to_string(leaves);
    std::uint32_t free_slots = 0, free_points = 0;
    for (LeafId s = free_leaf_; s.valid(); s = leaves_[s.value].neighbour[0], ++free_slots)
        if (s.value < mesh_->halfedge_count() || s.value >= leaf_slots() || is_leaf(s) || free_slots == leaf_slots())
            return "slot " + std::to_string(s.value) + " is not free, but listed so";
    if (leaves + hole_slots + free_slots != leaf_slots()) return "slots are neither leaves nor free";
    for (std::uint32_t r = 0; r < mesh_->halfedge_count(); ++r) {
        const bool hole = mesh_->is_hole(mesh_->face(HalfedgeId(r)));
        if (covered[r] != (hole ? 0 : std::uint64_t{1} << k_max_bisection_depth))
            return "the leaves of root " + std::to_string(r) + " do not cover it once";
    }
    for (std::uint32_t p = fixed_points; p < sites_.size(); ++p) {
        midpoints += sites_[p].root.valid();
        if (sites_[p].root.valid() != (used[p] != 0))
            return "point " + std::to_string(p) + " is in use and without leaf, or the reverse";
    }
    if (midpoints != midpoint_count_)
        return "the midpoint count is " + std::to_string(midpoint_count_) + ", not " + std::to_string(midpoints);
    for (PointId p = free_point_; p.valid(); p.value = sites_[p.value].at.x, ++free_points)
        if (p.value < fixed_points || p.value >= point_slots() || is_point(p) || free_points == point_slots())
            return "point " + std::to_string(p.value) + " is not free, but listed so";
    if (midpoints + free_points != sites_.size() - fixed_points) return "points are neither used nor free";
    if (leaf_count_ > leaf_capacity_ || midpoint_count_ > midpoint_capacity_) return "there is more than the capacity";
    return std::nullopt;
}

std::optional<std::string> BisectionForest::check() const {
    for (std::uint32_t s = 0; s < leaf_slots(); ++s) {
        if (leaves_[s].depth == k_dead) continue;
        if (auto fault = check_leaf(s)) return fault;
    }
    return check_pool();
}

}  // namespace tetrakis
