#include "sqrt3_forest.hpp"

#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "tree_forest_change.hpp"

#include <algorithm>
#include <cassert>
#include <tuple>

namespace tetrakis {

Sqrt3Forest::Sqrt3Forest(const ControlMesh& mesh, const std::function<bool(EdgeId)>& kept)
    : lattice_(mesh, kept), child_(mesh.face_count(), std::uint32_t{k_whole}), known_(lattice_) {
    if (!mesh.all_triangles())
        throw Error(ErrorCode::unsupported,
                    "adaptive sqrt3 refinement takes no other faces than triangles; triangulate the mesh",
                    mesh.data().source);
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (mesh.is_hole(FaceId(f)))
            child_[f] = k_dead;
        else
            ++root_leaves_;
}

// Names and slots.

std::uint32_t Sqrt3Forest::slot_of(int level, std::uint64_t face) const {
    if (level == 0) return static_cast<std::uint32_t>(face);
    const std::uint32_t parent = slot_of(level - 1, face / 3);
    if (parent == k_no_slot || !is_split(parent)) return k_no_slot;
    return first_child(child_[parent]) + static_cast<std::uint32_t>(face % 3);
}

LeafId Sqrt3Forest::find(const Sqrt3Triangle& triangle) const {
    const LeafId leaf(slot_of(triangle.level, triangle.face));
    return is_leaf(leaf) && triangle_of(leaf.value) == triangle ? leaf : LeafId{};
}

// Mesh.

// The forest's number of a half-edge that has this number in the lattice.
std::uint32_t Sqrt3Forest::beyond(int level, std::uint64_t twin) const {
    if (twin == Sqrt3Lattice::none) return k_kept;
    const std::uint32_t slot = slot_of(level, Sqrt3Lattice::face(twin));
    return slot == k_no_slot ? k_apart : 3 * slot + static_cast<std::uint32_t>(twin % 3);
}

// The half-edge on the other side of an edge.
std::uint32_t Sqrt3Forest::across(std::uint32_t h) const {
    const Sqrt3Triangle t = triangle_of(h / 3);
    return beyond(t.level, known_.twin(t.level, 3 * t.face + h % 3));
}

// Whether splitting this face cuts its first edge (Sqrt3Lattice).
bool Sqrt3Forest::is_cut(std::uint32_t slot) const {
    const Sqrt3Triangle t = triangle_of(slot);
    return known_.cut_side(t.level, t.face) != Sqrt3Lattice::none;
}

// The point over a half-edge of a split face, see Sqrt3Lattice::apex(). Both faces of a cut edge have records of its
// points; owns_cut() says whose record counts.
std::uint32_t Sqrt3Forest::apex(std::uint32_t h) const {
    std::uint32_t record = child_[h / 3];
    bool second = false;
    if (is_cut(h / 3)) {
        second = h % 3 == 1;
        const auto [face, slot, level] = records_[record];
        const std::uint64_t beyond = known_.beyond(level, 3 * face);
        if (beyond != Sqrt3Lattice::none && !lattice_.owns_cut(level, face, Sqrt3Lattice::face(beyond))) {
            record = child_[slot_of(level, Sqrt3Lattice::face(beyond))];
            second = !second;
        }
    }
    return mesh().vertex_count() + 2 * record + (second ? 1 : 0);
}

// The point where a half-edge starts. O(level) on average.
std::uint32_t Sqrt3Forest::origin(std::uint32_t h) const {
    const std::uint32_t roots = mesh().face_count();
    while (h / 3 >= roots) {
        const std::uint32_t side = h % 3;
        h = over(h / 3);
        if (h % 3 == 0 && is_cut(h / 3)) {
            if (side != 2) return apex(h + side);
            h += 2;
        } else if (side == 2) {
            return apex(h);
        } else if (side == 1) {
            const std::uint32_t twin = across(h);
            if (twin != k_kept) return apex(twin);
            h = next(h);
        }
    }
    return mesh().origin(HalfedgeId(h)).value;
}

std::array<PointId, 3> Sqrt3Forest::points(LeafId leaf) const {
    const std::scoped_lock lock(mutex_);
    const std::uint32_t h = 3 * leaf.value;
    if (leaf.value >= mesh().face_count()) {
        const std::uint32_t edge = over(leaf.value);
        if (is_half(leaf)) return {PointId(origin(edge)), PointId(origin(next(edge))), PointId(apex(edge))};
        // As origin(), but shared steps are made once.
        if (const std::uint32_t twin = across(edge); twin != k_kept)
            return {PointId(origin(edge)), PointId(apex(twin)), PointId(apex(edge))};
    }
    return {PointId(origin(h)), PointId(origin(h + 1)), PointId(origin(h + 2))};
}

Site Sqrt3Forest::point_site(PointId point) const {
    if (point.value < mesh().vertex_count()) {
        const HalfedgeId h = mesh().vertex_halfedge(VertexId(point.value));
        const Sqrt3Cell root = Sqrt3Lattice::cell(mesh().face(h));
        return sqrt3_site(mesh(), root.root, root.corner[h.value % 3], 0);
    }
    const std::uint32_t made = point.value - mesh().vertex_count();
    const Record& record = records_[made / 2];
    const Sqrt3Cell cell = lattice_.cell(record.level, record.face);
    return sqrt3_site(mesh(), cell.root, Sqrt3Lattice::apex(cell, made % 2), sqrt3_lattice_level(record.level + 1));
}

// The leaf that has a half-edge of a level; this must be an edge of the mesh.
LeafId Sqrt3Forest::leaf_with(int level, std::uint64_t h) const {
    const std::uint64_t face = Sqrt3Lattice::face(h);
    const std::uint32_t slot = slot_of(level, face);
    // A half-edge of the mesh whose face does not exist: if it is over an edge that was not flipped, the previous level
    // has it, too; else it is the second side of a half triangle on the other side.
    if (slot == k_no_slot && level % 2 != 0 && known_.twin(level, h) == Sqrt3Lattice::none)
        return leaf_with(level - 1, face);
    if (slot == k_no_slot) return LeafId(slot_of(level, known_.twin(level - 1, face)));
    return LeafId(is_split(slot) ? child_over(3 * slot + static_cast<std::uint32_t>(h % 3)) : slot);
}

std::array<LeafId, 2> Sqrt3Forest::neighbours(LeafId leaf, int side) const {
    const Sqrt3Triangle t = triangle(leaf);
    const std::scoped_lock lock(mutex_);
    int level = t.level;
    std::uint64_t h = 3 * t.face + static_cast<std::uint64_t>(side);
    if (t.half && side == 0) {
        --level;
        h = t.face;
    } else if (t.half && side == 1) {
        h = 3 * known_.twin(level - 1, t.face);
    }
    std::uint64_t other = known_.twin(level, h);
    if (other == Sqrt3Lattice::none) other = known_.beyond(level, h);
    if (other == Sqrt3Lattice::none || known_.is_hole(level, Sqrt3Lattice::face(other))) return {};
    return {leaf_with(level, other), LeafId{}};
}

std::vector<LeafId> Sqrt3Forest::ordered_leaves() const {
    std::vector<LeafId> leaves;
    detail::reserve_large(leaves, leaf_count());
    for_each_leaf([&](LeafId leaf, FaceId) { leaves.push_back(leaf); });
    return leaves;
}

std::vector<Sqrt3Triangle> Sqrt3Forest::leaves() const {
    std::vector<Sqrt3Triangle> leaves;
    detail::reserve_large(leaves, leaf_count());
    for_each_leaf([&](LeafId leaf, FaceId) { leaves.push_back(triangle(leaf)); });
    return leaves;
}

ExportedTriangles Sqrt3Forest::exported() const {
    ExportedTriangles out;
    for_each_leaf([&](LeafId leaf, FaceId control_face) {
        out.leaves.push_back(leaf);
        out.faces.push_back(control_face);
        const auto [a, b, c] = points(leaf);
        out.triangles.push_back({a.value, b.value, c.value});
    });
    detail::number_points(out, *this, leaf_count() / 2);
    return out;
}

// Changes.

// Adds a face that is not split, with the faces that must be split with it or before it.
void Sqrt3Forest::add_needed(const Sqrt3Triangle& face, detail::PoolVector<Sqrt3Triangle>& wanted) const {
    std::size_t begin = wanted.size();
    wanted.push_back(face);
    while (begin < wanted.size()) {
        const std::uint8_t level = wanted[begin].level;
        // The faces of one level follow one another.
        const auto need = [&](int at, std::uint64_t number) {
            const Sqrt3Triangle f{static_cast<std::uint8_t>(at), false, number};
            if (number == Sqrt3Lattice::none || is_split(at, number)) return;
            if (std::find(wanted.begin() + static_cast<std::ptrdiff_t>(begin), wanted.end(), f) == wanted.end())
                wanted.push_back(f);
        };
        std::size_t end = wanted.size();
        for (std::size_t i = begin; i < end; ++i) need(level, known_.partner(level, wanted[i].face));
        end = wanted.size();
        for (std::size_t i = begin; i < end && level > 0; ++i) {
            const std::uint64_t h = wanted[i].face, t = known_.twin(level - 1, h);
            need(level - 1, Sqrt3Lattice::face(h));
            if (t != Sqrt3Lattice::none) need(level - 1, Sqrt3Lattice::face(t));
        }
        begin = end;
    }
}

// The faces that must be split in order to split these leaves, coarsest first.
detail::PoolVector<Sqrt3Triangle> Sqrt3Forest::wanted(std::span<const LeafId> marked) const {
    detail::PoolVector<Sqrt3Triangle> result;
    result.reserve(marked.size());
    for (const LeafId leaf : marked) {
        const auto [level, half, face] = triangle_of(leaf.value);
        const auto above = static_cast<std::uint8_t>(level - 1);
        if (half)
            add_needed({above, false, Sqrt3Lattice::face(known_.twin(above, face))}, result);
        else if (known_.partner(level, face) != Sqrt3Lattice::none)
            add_needed({level, false, face}, result);
        else
            result.push_back({level, false, face});  // all that it needs is split already
    }
    // Often a call splits all leaves, in their order.
    if (!std::is_sorted(result.begin(), result.end())) std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

void Sqrt3Forest::refine(std::span<const LeafId> marked, ForestChange& change, Changed* removed) {
    assert(std::ranges::all_of(marked, [&](LeafId leaf) { return is_leaf(leaf); }));
    const detail::PoolVector<Sqrt3Triangle> wanted = this->wanted(marked);  // `marked` may refer to change.created
    for (const int deepest = max_level(); const Sqrt3Triangle& face : wanted)
        if (face.level >= deepest)
            throw Error(ErrorCode::unsupported, "level " + std::to_string(deepest) +
                                                    " is the deepest that has numbers; its faces cannot be split");
    std::vector<LeafId>& created = change.created;
    created.clear();
    change.reshaped.clear();
    if (removed != nullptr) removed->clear();
    // Allocate all memory first, also for the search of twins: nothing may throw once the forest has changed.
    const std::size_t fresh = wanted.size() - std::min(wanted.size(), free_records_.size());
    if (child_.size() + 3 * std::uint64_t{fresh} > k_max_slots)
        throw Error(ErrorCode::memory_limit, "the hierarchy would have more triangles than 32 bits can number");
    detail::make_room(records_, records_.size() + fresh);
    detail::make_room(child_, child_.size() + 3 * fresh);
    detail::reserve_large(created, 6 * wanted.size());
    if (removed != nullptr) removed->reserve(4 * wanted.size());
    detail::PoolVector<std::uint32_t> fresh_records;
    fresh_records.reserve(wanted.size());
    detail::PoolVector<LeafId> whole;  // leaves that were half before the call
    whole.reserve(3 * wanted.size());
    detail::PoolVector<Twins> twins(wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i)
        for (std::uint64_t side = 0; side < 3; ++side)
            twins[i][side] = known_.twin(wanted[i].level, 3 * wanted[i].face + side);
    for (std::size_t i = 0; i < wanted.size(); ++i) fresh_records.push_back(split(wanted[i], twins[i], whole, removed));
    const auto is_new_leaf = [&](std::uint32_t slot) {
        if (child_[slot] == k_whole_now) child_[slot] = k_whole;
        if (child_[slot] == k_half_now) child_[slot] = k_half;
        return is_leaf_slot(slot);
    };
    for (const std::uint32_t record : fresh_records)
        for (std::uint32_t side = 0; side < 3; ++side)
            if (is_new_leaf(first_child(record) + side)) created.emplace_back(first_child(record) + side);
    for (const LeafId leaf : whole)
        if (is_new_leaf(leaf.value)) created.push_back(leaf);
    forget_twins();
}

// Stored twins help the next change, but should not take more memory than the forest.
void Sqrt3Forest::forget_twins() {
    if (known_.memory_bytes() > child_.capacity() * sizeof(child_[0])) known_ = Sqrt3Lattice(lattice_);
}

// Splits a face; faces of coarser levels must be split first. Returns the record.
std::uint32_t Sqrt3Forest::split(const Sqrt3Triangle& at, const Twins& twins, detail::PoolVector<LeafId>& whole,
                                 Changed* removed) {
    const auto [level, half, face] = at;
    const std::uint32_t slot = slot_of(level, face);
    const auto was = [&](std::uint32_t leaf) {
        if (removed != nullptr) removed->emplace_back(leaf, triangle_of(leaf));
    };
    if (child_[slot] == k_whole) was(slot);
    const std::uint32_t record = detail::take_free(free_records_, records_);
    if (first_child(record) == child_.size()) child_.resize(child_.size() + 3);
    records_[record] = {face, slot, level};
    child_[slot] = record;
    for (std::uint32_t side = 0; side < 3; ++side) {
        std::uint32_t& child = child_[first_child(record) + side];
        const std::uint32_t twin = beyond(level, twins[side]);
        child = k_whole_now;
        if (twin == k_kept) continue;
        if (twin == k_apart || !is_split(twin / 3)) {
            child = k_half_now;
            continue;
        }
        const std::uint32_t other = child_over(twin);
        if (child_[other] == k_half) {
            was(other);
            whole.emplace_back(other);
        }
        child_[other] = k_whole_now;
    }
    return record;
}

Sqrt3Forest::Group Sqrt3Forest::group_of(std::uint32_t record) const {
    Group group;
    bool leaves = true;
    const auto add = [&](std::uint32_t slot) {
        if (std::find(group.slots.begin(), group.slots.end(), slot) != group.slots.end()) return;
        group.slots.push_back(slot);
        leaves = leaves && is_leaf_slot(slot);
    };
    const Record& at = records_[record];
    std::array<std::uint32_t, 2> sides{record, record};
    if (const std::uint64_t partner = known_.partner(at.level, at.face); partner != Sqrt3Lattice::none)
        sides[1] = child_[slot_of(at.level, partner)];
    for (const std::uint32_t of : sides)
        for (std::uint32_t side = 0; side < 3; ++side) add(first_child(of) + side);
    group.own = group.slots.size();
    for (const std::uint32_t of : sides)
        for (std::uint32_t side = 0; side < 3 && leaves; ++side) {
            if (child_[first_child(of) + side] == k_half) continue;
            const std::uint32_t twin = across(3 * records_[of].slot + side);
            if (twin != k_kept) add(child_over(twin));
        }
    return leaves ? group : Group{};
}

std::vector<LeafId> Sqrt3Forest::group(LeafId leaf) const {
    const std::uint32_t roots = mesh().face_count();
    if (leaf.value < roots) return {};
    const std::scoped_lock lock(mutex_);
    Group found = group_of((leaf.value - roots) / 3);
    if (found.slots.empty() && !is_half(leaf))
        if (const std::uint32_t twin = across(over(leaf.value)); twin != k_kept) found = group_of(child_[twin / 3]);
    std::vector<LeafId> result;
    for (std::size_t i = 0; i < found.own; ++i) result.emplace_back(found.slots[i]);
    return result;
}

void Sqrt3Forest::coarsen(std::span<const LeafId> marked, ForestChange& change, Changed& removed) {
    assert(std::ranges::all_of(marked, [&](LeafId leaf) { return is_leaf(leaf); }));
    removed.clear();
    const std::uint32_t roots = mesh().face_count();
    std::vector<std::uint32_t> wanted, records;
    for (const LeafId leaf : marked) {
        wanted.push_back(leaf.value);
        if (leaf.value < roots) continue;
        records.push_back((leaf.value - roots) / 3);
    }
    std::sort(wanted.begin(), wanted.end());
    std::sort(records.begin(), records.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(records_[a].level, records_[a].face) < std::tie(records_[b].level, records_[b].face);
    });
    records.erase(std::unique(records.begin(), records.end()), records.end());
    std::vector<std::uint32_t> groups;
    std::erase_if(records, [&](std::uint32_t record) {
        const Group group = group_of(record);
        const std::span own(group.slots.data(), group.own);
        const bool all = !own.empty() && std::all_of(own.begin(), own.end(), [&](std::uint32_t slot) {
            return std::binary_search(wanted.begin(), wanted.end(), slot);
        });
        if (all) groups.insert(groups.end(), group.slots.begin(), group.slots.end());
        return !all;
    });
    std::vector<LeafId>& created = change.created;
    created.clear();
    change.reshaped.clear();
    created.reserve(records.size() + groups.size());
    detail::make_room(free_records_, free_records_.size() + records.size());
    for (const std::uint32_t slot : groups)
        if (!std::binary_search(wanted.begin(), wanted.end(), slot)) removed.emplace_back(slot, triangle_of(slot));
    std::sort(removed.begin(), removed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    removed.erase(std::unique(removed.begin(), removed.end()), removed.end());
    // The rest does not throw.
    for (const std::uint32_t record : records) {
        child_[records_[record].slot] = k_whole;
        created.emplace_back(records_[record].slot);
        free_records_.push_back(record);
        for (std::uint32_t side = 0; side < 3; ++side) child_[first_child(record) + side] = k_dead;
    }
    for (const std::uint32_t slot : groups) {
        if (child_[slot] != k_whole) continue;
        child_[slot] = k_half;
        created.emplace_back(slot);
    }
    forget_twins();
}

std::uint64_t Sqrt3Forest::memory_bytes() const {
    const std::scoped_lock lock(mutex_);
    return known_.memory_bytes() + child_.capacity() * sizeof(child_[0]) + records_.capacity() * sizeof(Record) +
           free_records_.capacity() * sizeof(free_records_[0]);
}

void Sqrt3Forest::shrink() {
    known_ = Sqrt3Lattice(lattice_);  // without stored twins
    child_.shrink_to_fit();
    records_.shrink_to_fit();
    free_records_.shrink_to_fit();
}

}  // namespace tetrakis
