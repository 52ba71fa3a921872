#include "sqrt3_forest.hpp"

#include <algorithm>

// How the triangles of a level lie together. The rules are those of Sqrt3Lattice, from each level to the next: a link
// is between half-edges of two faces of a level, both of which have slots; half triangles have those of their faces, as
// far as these are there. Where a crease has become smooth the lattice is asked instead.
namespace tetrakis {

/// The half-edge with a number of the lattice, on the level of h.
std::uint32_t Sqrt3Forest::beyond(std::uint32_t h, std::uint64_t twin) const {
    if (twin == Sqrt3Lattice::none) return k_kept;
    const std::uint32_t slot = slot_of(level_of(h / 3), Sqrt3Lattice::face(twin));
    return slot == k_no_slot ? k_apart : 3 * slot + static_cast<std::uint32_t>(twin % 3);
}

/// across(), where a crease may have become smooth.
std::uint32_t Sqrt3Forest::beyond(std::uint32_t h) const {
    const Sqrt3Triangle t = triangle_of(h / 3);
    const std::scoped_lock lock(shared_.mutex);
    return beyond(h, shared_.lattice.twin(t.level, 3 * t.face + h % 3));
}

/// Both faces of a cut edge have its points; those of one of the two records stand for them.
std::uint32_t Sqrt3Forest::cut_apex(std::uint32_t h) const {
    std::uint32_t record = child_[h / 3];
    bool second = h % 3 == 1;
    if (lattice_.has_lines()) {
        const auto [face, slot, level, live] = records_[record];
        const std::scoped_lock lock(shared_.mutex);
        const std::uint64_t beyond = shared_.lattice.beyond(level, 3 * face);
        if (beyond != Sqrt3Lattice::none && !shared_.lattice.owns_cut(level, face, Sqrt3Lattice::face(beyond))) {
            record = child_[slot_of(level, Sqrt3Lattice::face(beyond))];
            second = !second;
        }
    }
    return mesh().vertex_count() + 2 * record + (second ? 1 : 0);
}

/// The point that a half-edge leaves. O(1) on the average, O(level) at most.
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
    const std::uint32_t h = 3 * leaf.value;
    if (leaf.value >= mesh().face_count()) {
        const std::uint32_t edge = over(leaf.value);
        if (child_[leaf.value] == k_half)
            return {PointId(origin(edge)), PointId(origin(next(edge))), PointId(apex(edge))};
        // As origin(), but for what all three share.
        if (const std::uint32_t twin = across(edge); twin != k_kept)
            return {PointId(origin(edge)), PointId(apex(twin)), PointId(apex(edge))};
    }
    return {PointId(origin(h)), PointId(origin(h + 1)), PointId(origin(h + 2))};
}

Site Sqrt3Forest::site(PointId point) const {
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

void Sqrt3Forest::link(std::uint32_t h, std::uint32_t twin) {
    across_[h] = twin;
    across_[twin] = h;
}

/// The links that splitting a face makes along an edge that is not flipped.
void Sqrt3Forest::keep(std::uint32_t h) {
    const std::uint32_t child = child_over(h), after = child_over(next(h));
    across_[3 * child] = k_kept;
    if (!is_cut(h / 3)) return link(3 * child + 1, 3 * after + 2);
    // (first, second, opposite corner); before it a third of the edge, and after it.
    across_[3 * after + 2] = k_kept;
    link(3 * child + 2, 3 * child_over(next(next(h))) + 2);
}

/// The links of the two faces that the edge between two split ones is flipped to.
void Sqrt3Forest::flip(std::uint32_t h, std::uint32_t twin) {
    const std::uint32_t here = child_over(h), there = child_over(twin);
    link(3 * here + 1, 3 * there + 1);
    link_first(here, twin);
    link_first(there, h);
}

/// The first side of a face that lies across an edge, by the half-edge beyond the edge.
void Sqrt3Forest::link_first(std::uint32_t slot, std::uint32_t beyond) {
    if (!is_cut(beyond / 3))
        link(3 * slot, 3 * child_over(next(beyond)) + 2);
    else if (beyond % 3 == 1)
        link(3 * slot, 3 * first_child(child_[beyond / 3]) + 1);
    else
        across_[3 * slot] = k_kept;  // a third of the cut edge
}

void Sqrt3Forest::unlink(std::uint32_t slot) {
    for (std::uint32_t h = 3 * slot; h < 3 * slot + 3; ++h) {
        if (across_[h] < k_apart) across_[across_[h]] = k_apart;
        across_[h] = k_apart;
    }
}

}  // namespace tetrakis
