#include "vertex_forest.hpp"

#include "../base/error.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace tetrakis {

VertexForest::VertexForest(VertexRoots roots)
    : roots_(std::move(roots)),
      leaf_count_(roots_.count()),
      child_(roots_.count(), k_unsplit),
      marks_(roots_.count(), 0) {}

VertexForest::Place VertexForest::outer(std::uint32_t slot, int side) const {
    if (const Joint* joint = joint_of(slot)) {
        const Joint::Side& other = joint->sides[static_cast<std::size_t>(4 * number(slot) + side)];
        if (other.leads == Joint::Leads::in_place) return {other.slot, other.side};
    }
    return {slot, side};
}

VertexForest::Place VertexForest::existing(std::uint32_t slot, int side) const {
    if (child_[slot] != k_dead) return {slot, side};
    const Place place = outer(slot, side);
    return place.slot == slot ? Place{k_boundary, 0} : place;
}

VertexForest::Across VertexForest::beyond(std::uint32_t slot, int side) const {
    if (is_root(slot)) {
        const std::uint32_t link = roots_.link[4 * std::size_t{slot} + static_cast<std::size_t>(side)];
        return link == k_boundary ? Across{k_boundary, 0} : Across{link / 4, static_cast<int>(link % 4)};
    }
    if (const Joint* joint = joint_of(slot)) {
        const Joint::Side& other = joint->sides[static_cast<std::size_t>(4 * number(slot) + side)];
        if (other.leads == Joint::Leads::to) return {other.slot, other.side};
        if (other.leads == Joint::Leads::in_place) {
            slot = other.slot;
            side = other.side;
        }
    }
    const std::uint32_t record = record_of(slot);
    const int child = number(slot);
    // Inside, a child meets the next one and the one before across the sides that face them.
    if (side == (child + 1) % 4) return {first_child(record) + static_cast<std::uint32_t>(side), (side + 2) % 4};
    if (side == (child + 2) % 4)
        return {first_child(record) + static_cast<std::uint32_t>((child + 3) % 4), (side + 2) % 4};
    const std::uint32_t link = records_[record].link[static_cast<std::size_t>(side)];
    if (link >= k_coarser) return {link, 0};
    // Side s has the children s and s + 1 beside it; from the other side they come in the opposite order.
    const std::uint32_t other = link % 4;
    const Place place =
        existing(first_child(link / 4) + (child == side ? (other + 1) % 4 : other), static_cast<int>(other));
    return {place.slot, place.side};
}

std::uint8_t VertexForest::smooth_from(std::uint32_t slot, int side) const {
    if (roots_.all_stay()) return VertexRoots::never;
    const auto s = static_cast<std::size_t>(side);
    if (is_root(slot)) return roots_.smooth_from[4 * std::size_t{slot} + s];
    if (const Joint* joint = joint_of(slot))
        return joint->children[static_cast<std::size_t>(number(slot))].smooth_from[s];
    const Record& above = records_[record_of(slot)];
    return above.smooth_from[std::popcount(above.creases & ((1u << side) - 1)) == 0 ? 0 : 1];
}

std::uint32_t VertexForest::live_children(std::uint32_t record) const {
    if (records_[record].joint == k_no_joint) return 4;
    std::uint32_t count = 0;
    for (const VertexJoint::Child& child : joints_[records_[record].joint].children) count += child.exists ? 1 : 0;
    return count;
}

int VertexForest::level(LeafId leaf) const {
    return is_root(leaf.value) ? 0 : records_[record_of(leaf.value)].level + 1;
}

VertexCell VertexForest::cell(LeafId leaf) const {
    if (is_root(leaf.value)) return {leaf.value, {0, 0}, 0};
    const Record& r = records_[record_of(leaf.value)];
    const int child = number(leaf.value);
    return {r.root,
            {2 * r.at.x + (child == 1 || child == 2 ? 1 : 0), 2 * r.at.y + (child >= 2 ? 1 : 0)},
            static_cast<std::uint8_t>(r.level + 1)};
}

std::array<LeafId, 2> VertexForest::neighbours(LeafId leaf, int side) const {
    const Across next = across(leaf.value, side);
    if (next.slot == k_boundary) return {};
    if (next.slot == k_coarser) {
        const Place place = outer(leaf.value, side);
        return {LeafId(across(records_[record_of(place.slot)].parent, place.side).slot), LeafId{}};
    }
    if (!is_split(next.slot)) return {LeafId(next.slot), LeafId{}};
    const std::uint32_t first = first_child(child_[next.slot]), t = static_cast<std::uint32_t>(next.side);
    std::array<LeafId, 2> found{};
    std::size_t count = 0;
    for (const std::uint32_t child : {(t + 1) % 4, t})
        if (const Place place = existing(first + child, next.side); place.slot != k_boundary)
            found[count++] = LeafId(place.slot);
    return found;
}

LeafId VertexForest::across_crease(LeafId leaf, int side) const {
    return is_crease(leaf.value, side) ? LeafId(beyond(leaf.value, side).slot) : LeafId{};
}

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

std::vector<LeafId> VertexForest::ordered_leaves() const {
    std::vector<LeafId> leaves;
    leaves.reserve(leaf_count_);
    std::vector<std::uint32_t> open;
    for (std::uint32_t r = 0; r < roots_.count(); ++r) {
        open.push_back(r);
        while (!open.empty()) {
            const std::uint32_t slot = open.back();
            open.pop_back();
            if (is_split(slot))
                for (std::uint32_t k = 4; k-- > 0;) open.push_back(first_child(child_[slot]) + k);
            else if (child_[slot] == k_unsplit)
                leaves.emplace_back(slot);
        }
    }
    return leaves;
}

void VertexForest::require_leaves(std::span<const LeafId> leaves) const {
    for (const LeafId leaf : leaves)
        if (!is_leaf(leaf))
            throw Error(ErrorCode::invalid_input,
                        "cell " + std::to_string(leaf.value) +
                            " is not a leaf of the forest (any more): it was split or merged, or never existed");
}

std::uint64_t VertexForest::memory_bytes() const {
    std::uint64_t joints = roots_.joints.capacity() * sizeof(VertexJoint);
    for (const VertexJoint& joint : roots_.joints)
        joints += joint.cells.capacity() * sizeof(joint.cells[0]) +
                  joint.children.capacity() * sizeof(joint.children[0]) +
                  (joint.joined.capacity() + joint.in_place.capacity()) * sizeof(joint.joined[0]);
    return joints + roots_.link.capacity() * sizeof(std::uint32_t) + roots_.face.capacity() * sizeof(FaceId) +
           roots_.crease.capacity() + roots_.hole.capacity() + child_.capacity() * sizeof(std::uint32_t) +
           roots_.smooth_from.capacity() + roots_.joint_cells.capacity() * sizeof(VertexRoots::JointCell) +
           records_.capacity() * sizeof(Record) +
           (free_records_.capacity() + free_joints_.capacity() + records_of_joint_.capacity()) * sizeof(std::uint32_t) +
           joints_.capacity() * sizeof(Joint) + marks_.capacity();
}

void VertexForest::shrink() {
    roots_.link.shrink_to_fit();
    roots_.crease.shrink_to_fit();
    roots_.face.shrink_to_fit();
    roots_.hole.shrink_to_fit();
    roots_.smooth_from.shrink_to_fit();
    roots_.joint_cells.shrink_to_fit();
    child_.shrink_to_fit();
    records_.shrink_to_fit();
    free_records_.shrink_to_fit();
    joints_.shrink_to_fit();
    free_joints_.shrink_to_fit();
    marks_.shrink_to_fit();
}

}  // namespace tetrakis
