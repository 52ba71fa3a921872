#include "tetrakis/hier/sqrt3_slots.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/parallel.hpp"

#include <algorithm>
#include <tuple>

namespace tetrakis {

Sqrt3Slots::Sqrt3Slots(const ControlMesh& mesh)
    : forest_(mesh), child_(mesh.face_count(), std::uint32_t{k_whole}), shared_(forest_.lattice()) {
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (mesh.is_hole(FaceId(f))) child_[f] = k_dead;
}

// Names and slots.

std::uint32_t Sqrt3Slots::slot_of(int level, std::uint64_t face) const {
    std::array<std::uint8_t, 64> side;
    for (int k = level; k > 0; --k) {
        side[static_cast<std::size_t>(k - 1)] = static_cast<std::uint8_t>(face % 3);
        face /= 3;
    }
    auto slot = static_cast<std::uint32_t>(face);
    for (int k = 0; k < level; ++k) {
        if (!is_split(slot)) return k_no_slot;
        slot = first_child(child_[slot]) + side[static_cast<std::size_t>(k)];
    }
    return slot;
}

Sqrt3Triangle Sqrt3Slots::triangle_of(std::uint32_t slot) const {
    const std::uint32_t roots = mesh().face_count();
    if (slot < roots) return {0, false, slot};
    const Record& record = records_[(slot - roots) / 3];
    return {static_cast<std::uint8_t>(record.level + 1), child_[slot] == k_half, 3 * record.face + (slot - roots) % 3};
}

Sqrt3Triangle Sqrt3Slots::triangle(LeafId leaf) const { return triangle_of(leaf.value); }

LeafId Sqrt3Slots::find(const Sqrt3Triangle& triangle) const {
    const LeafId leaf(slot_of(triangle.level, triangle.face));
    return is_leaf(leaf) && triangle_of(leaf.value) == triangle ? leaf : LeafId{};
}

std::array<Sqrt3Vertex, 3> Sqrt3Slots::corners(const Sqrt3Triangle& t) const {
    const std::scoped_lock lock(shared_.mutex);
    Sqrt3Lattice& lattice = shared_.lattice;
    if (!t.half) {
        const std::uint64_t h = 3 * t.face;
        return {lattice.origin(t.level, h), lattice.origin(t.level, h + 1), lattice.origin(t.level, h + 2)};
    }
    const int above = t.level - 1;
    return {lattice.origin(above, t.face), lattice.origin(above, Sqrt3Lattice::next(t.face)),
            lattice.apex(above, t.face)};
}

PointId Sqrt3Slots::point(const Sqrt3Vertex& v) const {
    using Kind = Sqrt3Vertex::Kind;
    if (v.kind == Kind::control) return PointId(static_cast<std::uint32_t>(v.key));
    const std::uint64_t face = v.kind == Kind::centre ? v.key : Sqrt3Lattice::face(v.key);
    const std::uint32_t record = child_[slot_of(v.birth - 1, face)];
    return PointId(mesh().vertex_count() + 2 * record + (v.kind == Kind::second ? 1 : 0));
}

Sqrt3Slots::Places Sqrt3Slots::places(const Sqrt3Levels& levels) const {
    using Kind = Sqrt3Vertex::Kind;
    Places places;
    places.slot.resize(levels.levels.size());
    places.point.resize(levels.vertices.size());
    for (std::uint32_t v = 0; v < mesh().vertex_count(); ++v) places.point[v] = v;
    for (std::size_t k = 0; k < levels.levels.size(); ++k) {
        const Sqrt3Level& level = levels.levels[k];
        auto& slot = places.slot[k];
        slot.resize(level.face_count());
        if (k == 0)
            for (std::uint32_t f = 0; f < level.face_count(); ++f)
                slot[f] = static_cast<std::uint32_t>(level.number[f]);
        if (k + 1 < levels.levels.size()) places.slot[k + 1].resize(levels.levels[k + 1].face_count());
        for_each_index(level.face_count(), [&](std::uint32_t f) {
            if (level.split[f] == 0) return;
            for (std::uint32_t side = 0; side < 3; ++side)
                if (const std::uint32_t child = level.child_over(3 * f + side); Sqrt3Level::there(child))
                    places.slot[k + 1][child] = child_over(slot[f], side);
            const std::uint32_t first = mesh().vertex_count() + 2 * child_[slot[f]], apex = level.apex[f];
            if (levels.vertices[apex].kind == Kind::centre) {
                places.point[apex] = first;
                return;
            }
            // Those of a cut edge are those of the face that names them.
            for (const std::uint32_t v : {apex, levels.beside(apex)})
                if (const Sqrt3Vertex& vertex = levels.vertices[v]; Sqrt3Lattice::face(vertex.key) == level.number[f])
                    places.point[v] = first + (vertex.kind == Kind::second ? 1 : 0);
        });
    }
    return places;
}

bool Sqrt3Slots::is_vertex(const Sqrt3Vertex& v) const {
    using Kind = Sqrt3Vertex::Kind;
    if (v.kind == Kind::control)
        return v.birth == 0 && v.key < mesh().vertex_count() &&
               mesh().vertex_halfedge(VertexId(static_cast<std::uint32_t>(v.key))).valid();
    if (v.birth == 0 || v.birth > forest_.max_level()) return false;
    const int above = v.birth - 1;
    std::uint64_t faces = mesh().face_count();
    for (int k = 0; k < above; ++k) faces *= 3;
    const std::uint64_t face = v.kind == Kind::centre ? v.key : Sqrt3Lattice::face(v.key);
    if (face >= faces || (v.kind != Kind::centre && v.key % 3 != 0)) return false;
    // The point over a side says whether it is this kind that the face gets.
    const std::scoped_lock lock(shared_.mutex);
    const Sqrt3Vertex first = shared_.lattice.apex(above, 3 * face), second = shared_.lattice.apex(above, 3 * face + 1);
    return v == first || v == second;
}

// Mesh.

// The leaf that has a half-edge of a level which is one of the mesh.
LeafId Sqrt3Slots::leaf_with(Sqrt3Lattice& lattice, int level, std::uint64_t h) const {
    const std::uint64_t face = Sqrt3Lattice::face(h);
    const std::uint32_t slot = slot_of(level, face);
    // A face that is not there but has the half-edge: over an edge that was not flipped, which the level before has,
    // too; else a half triangle on the other side has it for its second side.
    if (slot == k_no_slot && level % 2 != 0 && lattice.twin(level, h) == Sqrt3Lattice::none)
        return leaf_with(lattice, level - 1, face);
    if (slot == k_no_slot) return LeafId(slot_of(level, lattice.twin(level - 1, face)));
    if (is_split(slot)) return LeafId(first_child(child_[slot]) + static_cast<std::uint32_t>(h % 3));
    return LeafId(slot);
}

LeafId Sqrt3Slots::neighbour(LeafId leaf, int side) const {
    const Sqrt3Triangle t = triangle(leaf);
    const std::scoped_lock lock(shared_.mutex);
    Sqrt3Lattice& lattice = shared_.lattice;
    int level = t.level;
    std::uint64_t h = 3 * t.face + static_cast<std::uint64_t>(side);
    if (t.half && side == 0) {
        --level;
        h = t.face;
    } else if (t.half && side == 1) {
        h = 3 * lattice.twin(level - 1, t.face);
    }
    std::uint64_t other = lattice.twin(level, h);
    if (other == Sqrt3Lattice::none) other = lattice.beyond(level, h);
    if (other != Sqrt3Lattice::none && lattice.is_hole(level, Sqrt3Lattice::face(other))) return {};
    return other == Sqrt3Lattice::none ? LeafId{} : leaf_with(lattice, level, other);
}

std::vector<LeafId> Sqrt3Slots::ordered_leaves() const {
    std::vector<LeafId> leaves;
    leaves.reserve(leaf_count());
    std::vector<std::uint32_t> open;
    for (std::uint32_t root = 0; root < mesh().face_count(); ++root) {
        if (child_[root] == k_dead) continue;
        open.push_back(root);
        while (!open.empty()) {
            const std::uint32_t slot = open.back();
            open.pop_back();
            if (!is_split(slot)) {
                leaves.emplace_back(slot);
                continue;
            }
            for (std::uint32_t side = 3; side-- > 0;) open.push_back(first_child(child_[slot]) + side);
        }
    }
    return leaves;
}

// Changes.

// A face that the forest has split by now; those of coarser levels come first. Returns the record.
std::uint32_t Sqrt3Slots::split(const Sqrt3Face& face, const Twins& twins, Changed& changed) {
    const std::uint32_t slot = slot_of(face.level, face.face);
    if (child_[slot] == k_whole) changed.emplace_back(slot, triangle_of(slot));
    auto record = static_cast<std::uint32_t>(records_.size());
    if (free_records_.empty()) {
        records_.emplace_back();
        child_.resize(child_.size() + 3);
    } else {
        record = free_records_.back();
        free_records_.pop_back();
    }
    records_[record] = {face.face, slot, face.level, true};
    child_[slot] = record;
    for (std::uint32_t side = 0; side < 3; ++side) {
        const std::uint64_t twin = twins[side];
        const bool whole =
            twin == Sqrt3Lattice::none || forest_.is_split(Sqrt3Face{face.level, Sqrt3Lattice::face(twin)});
        child_[first_child(record) + side] = whole ? k_whole_now : k_half;
        if (!whole || twin == Sqrt3Lattice::none) continue;
        const std::uint32_t beyond = slot_of(face.level + 1, twin);
        if (beyond == k_no_slot || child_[beyond] != k_half) continue;
        changed.emplace_back(beyond, triangle_of(beyond));
        child_[beyond] = k_whole_now;
    }
    return record;
}

void Sqrt3Slots::refine(std::span<const LeafId> marked, std::vector<LeafId>& created, Changed& removed) {
    created.clear();
    removed.clear();
    std::vector<Sqrt3Face> faces;
    for (const LeafId leaf : marked) {
        const Sqrt3Triangle t = triangle(leaf);
        if (!t.half) {
            faces.push_back({t.level, t.face});
            if (shared_.lattice.partner(t.level, t.face) == Sqrt3Lattice::none) continue;
            const std::vector<Sqrt3Face> needed = forest_.needed(faces.back());
            faces.insert(faces.end(), needed.begin(), needed.end());
            continue;
        }
        Sqrt3Leaf half;
        half.level = static_cast<std::uint8_t>(t.level - 1);
        half.half = true;
        half.face = t.face;
        const std::vector<Sqrt3Face> needed = forest_.needed(half);
        faces.insert(faces.end(), needed.begin(), needed.end());
    }
    std::sort(faces.begin(), faces.end());
    faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
    // All memory first, and the twins, which take some to be found: nothing may throw once the forest has changed.
    const std::size_t fresh = faces.size() - std::min(faces.size(), free_records_.size());
    if (child_.size() + 3 * std::uint64_t{fresh} > k_max_slots)
        throw Error(ErrorCode::memory_limit, "the hierarchy would have more triangles than 32 bits can number");
    const auto room = [](auto& vector, std::size_t size) {
        if (size > vector.capacity()) vector.reserve(std::max(size, 2 * vector.capacity()));
    };
    room(records_, records_.size() + fresh);
    room(free_records_, records_.size() + fresh);
    room(child_, child_.size() + 3 * fresh);
    created.reserve(6 * faces.size());
    removed.reserve(4 * faces.size());
    std::vector<std::uint32_t> fresh_records;
    fresh_records.reserve(faces.size());
    std::vector<Twins> twins;
    twins.reserve(faces.size());
    for (const Sqrt3Face& face : faces) {
        Twins& of = twins.emplace_back();
        for (std::size_t side = 0; side < 3; ++side) of[side] = shared_.lattice.twin(face.level, 3 * face.face + side);
    }
    forest_.refine_closed(faces);
    for (std::size_t i = 0; i < faces.size(); ++i) fresh_records.push_back(split(faces[i], twins[i], removed));
    const auto is_new_leaf = [&](std::uint32_t slot) {
        if (child_[slot] == k_whole_now) child_[slot] = k_whole;
        return is_leaf_slot(slot);
    };
    for (const std::uint32_t record : fresh_records)
        for (std::uint32_t side = 0; side < 3; ++side)
            if (is_new_leaf(first_child(record) + side)) created.emplace_back(first_child(record) + side);
    for (const auto& [leaf, before] : removed)
        if (before.half && is_new_leaf(leaf.value)) created.push_back(leaf);
}

// The record of the triangle beyond the edge that a whole triangle lies across; none at the boundary.
std::uint32_t Sqrt3Slots::record_beyond(Sqrt3Lattice& lattice, std::uint32_t slot) const {
    const Sqrt3Triangle t = triangle_of(slot);
    if (t.level == 0 || t.half) return k_no_slot;
    const std::uint64_t twin = lattice.twin(t.level - 1, t.face);
    if (twin == Sqrt3Lattice::none) return k_no_slot;
    return child_[slot_of(t.level - 1, Sqrt3Lattice::face(twin))];
}

Sqrt3Slots::Group Sqrt3Slots::group_of(Sqrt3Lattice& lattice, std::uint32_t record) const {
    Group group;
    bool leaves = true;
    const auto add = [&](std::uint32_t slot) {
        if (std::find(group.slots.begin(), group.slots.end(), slot) != group.slots.end()) return;
        group.slots.push_back(slot);
        leaves = leaves && is_leaf_slot(slot);
    };
    const Record& at = records_[record];
    std::array<std::uint32_t, 2> sides{record, record};
    if (const std::uint64_t partner = lattice.partner(at.level, at.face); partner != Sqrt3Lattice::none)
        sides[1] = child_[slot_of(at.level, partner)];
    for (const std::uint32_t of : sides)
        for (std::uint32_t side = 0; side < 3; ++side) add(first_child(of) + side);
    group.own = group.slots.size();
    for (const std::uint32_t of : sides)
        for (std::uint32_t side = 0; side < 3 && leaves; ++side) {
            if (child_[first_child(of) + side] == k_half) continue;
            const std::uint64_t twin = lattice.twin(at.level, 3 * records_[of].face + side);
            if (twin != Sqrt3Lattice::none) add(slot_of(at.level + 1, twin));
        }
    return leaves ? group : Group{};
}

std::vector<LeafId> Sqrt3Slots::group(LeafId leaf) const {
    const std::uint32_t roots = mesh().face_count();
    if (leaf.value < roots) return {};
    const std::scoped_lock lock(shared_.mutex);
    Group found = group_of(shared_.lattice, (leaf.value - roots) / 3);
    if (found.slots.empty())
        if (const std::uint32_t beyond = record_beyond(shared_.lattice, leaf.value); beyond != k_no_slot)
            found = group_of(shared_.lattice, beyond);
    std::vector<LeafId> result;
    for (std::size_t i = 0; i < found.own; ++i) result.emplace_back(found.slots[i]);
    return result;
}

void Sqrt3Slots::coarsen(std::span<const LeafId> marked, std::vector<LeafId>& created, Changed& removed) {
    created.clear();
    removed.clear();
    const std::uint32_t roots = mesh().face_count();
    Sqrt3Lattice& lattice = shared_.lattice;
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
    std::vector<Sqrt3Face> faces;
    std::vector<std::uint32_t> groups;
    std::erase_if(records, [&](std::uint32_t record) {
        const Group group = group_of(lattice, record);
        const std::span own(group.slots.data(), group.own);
        const bool all = !own.empty() && std::all_of(own.begin(), own.end(), [&](std::uint32_t slot) {
            return std::binary_search(wanted.begin(), wanted.end(), slot);
        });
        if (all) {
            faces.push_back({records_[record].level, records_[record].face});
            groups.insert(groups.end(), group.slots.begin(), group.slots.end());
        }
        return !all;
    });
    created.reserve(records.size() + groups.size());
    for (const std::uint32_t slot : groups)
        if (!std::binary_search(wanted.begin(), wanted.end(), slot)) removed.emplace_back(slot, triangle_of(slot));
    std::sort(removed.begin(), removed.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    removed.erase(std::unique(removed.begin(), removed.end()), removed.end());
    forest_.coarsen(faces);  // all or nothing; what follows does not throw
    for (const std::uint32_t record : records) {
        records_[record].live = false;
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
}

// Checks.

std::optional<std::string> Sqrt3Slots::check() const {
    if (auto fault = forest_.check()) return fault;
    const std::scoped_lock lock(shared_.mutex);
    Sqrt3Lattice& lattice = shared_.lattice;
    for (std::uint32_t f = 0; f < mesh().face_count(); ++f) {
        const bool split = forest_.is_split(Sqrt3Face{0, f});
        const std::uint32_t state = child_[f], expected = mesh().is_hole(FaceId(f)) ? k_dead : k_whole;
        if (split ? !is_split(f) || state >= records_.size() : state != expected)
            return "control face " + std::to_string(f) + ": its slot is not as the forest has it";
    }
    std::size_t live = 0;
    for (std::uint32_t r = 0; r < records_.size(); ++r) {
        const Record& record = records_[r];
        if (!record.live) continue;
        ++live;
        const std::string name = "split triangle " + std::to_string(r);
        if (!forest_.is_split(Sqrt3Face{record.level, record.face})) return name + ": the forest has it whole";
        if (slot_of(record.level, record.face) != record.slot || child_[record.slot] != r)
            return name + ": it is not where its number says";
        for (std::uint32_t side = 0; side < 3; ++side) {
            const std::uint32_t state = child_[first_child(r) + side];
            const std::uint64_t twin = lattice.twin(record.level, 3 * record.face + side);
            const bool whole =
                twin == Sqrt3Lattice::none || forest_.is_split(Sqrt3Face{record.level, Sqrt3Lattice::face(twin)});
            if (state == k_dead || state == k_whole_now || (state == k_half) == whole)
                return name + ": the triangle over side " + std::to_string(side) + " is not as the one beyond asks";
        }
    }
    if (live != forest_.split_count())
        return std::string("the forest has more split triangles than there are slots for");
    if (live + free_records_.size() != records_.size()) return std::string("records that are neither used nor free");
    return std::nullopt;
}

std::uint64_t Sqrt3Slots::memory_bytes() const {
    return forest_.memory_bytes() + child_.capacity() * sizeof(child_[0]) + records_.capacity() * sizeof(Record) +
           free_records_.capacity() * sizeof(free_records_[0]);
}

void Sqrt3Slots::shrink() {
    child_.shrink_to_fit();
    records_.shrink_to_fit();
    free_records_.shrink_to_fit();
}

}  // namespace tetrakis
