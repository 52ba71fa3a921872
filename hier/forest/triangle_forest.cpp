#include "triangle_forest.hpp"

#include "../base/error.hpp"

#include <string>

namespace tetrakis {

TriangleForest::TriangleForest(const ControlMesh& mesh)
    : mesh_(&mesh),
      canonical_(mesh),
      root_count_(mesh.face_count()),
      root_link_(3 * std::size_t{mesh.face_count()}, k_boundary),
      child_(mesh.face_count(), k_unsplit),
      sites_(mesh.vertex_count()),
      marks_(mesh.face_count(), 0) {
    for (std::uint32_t f = 0; f < root_count_; ++f)
        if (mesh.face_size(FaceId(f)) != 3)
            throw Error(ErrorCode::unsupported, "face " + std::to_string(f) + " has " +
                                                    std::to_string(mesh.face_size(FaceId(f))) +
                                                    " corners, but a triangle forest needs triangles; triangulate it");
    for (std::uint32_t f = 0; f < root_count_; ++f) {
        if (mesh.is_hole(FaceId(f))) {
            child_[f] = k_dead;
            continue;
        }
        ++leaf_count_;
        for (std::uint32_t e = 0; e < 3; ++e) {
            const HalfedgeId h(3 * f + e), twin = mesh.twin(h);
            if (twin.valid() && !mesh.is_hole(mesh.face(twin)))
                root_link_[h.value] = 4 * (twin.value / 3) + twin.value % 3;
            Site& site = sites_[mesh.origin(h).value];
            if (site.root.valid()) continue;
            ++point_count_;
            site = canonical_.vertex(mesh.origin(h));
        }
    }
}

std::uint32_t TriangleForest::hanging_point(std::uint32_t slot, std::uint32_t edge) const {
    const Neighbour next = neighbour(slot, edge);
    if (next.slot >= k_boundary || !is_split(next.slot)) return PointId::none;
    return records_[child_[next.slot]].point[3 + next.edge];
}

int TriangleForest::level(LeafId leaf) const {
    return leaf.value < root_count_ ? 0 : records_[(leaf.value - root_count_) / 4].level + 1;
}

FaceId TriangleForest::face(LeafId leaf) const {
    return FaceId(leaf.value < root_count_ ? leaf.value : records_[(leaf.value - root_count_) / 4].face);
}

std::uint64_t TriangleForest::path(LeafId leaf) const {
    std::uint64_t path = 0;
    int shift = 0;
    for (std::uint32_t slot = leaf.value; slot >= root_count_; shift += 2) {
        path |= std::uint64_t{(slot - root_count_) % 4} << shift;
        slot = records_[(slot - root_count_) / 4].parent;
    }
    return path;
}

std::array<LeafId, 2> TriangleForest::neighbours(LeafId leaf, std::uint32_t edge) const {
    const Neighbour next = neighbour(leaf.value, edge);
    if (next.slot == k_boundary) return {};
    if (next.slot == k_coarser) {
        // The edge is half of one of the parent's, whose neighbour across is unsplit.
        const std::uint32_t parent = records_[(leaf.value - root_count_) / 4].parent;
        return {LeafId(neighbour(parent, edge).slot), LeafId{}};
    }
    if (!is_split(next.slot)) return {LeafId(next.slot), LeafId{}};
    const std::uint32_t first = first_child(child_[next.slot]);
    return {LeafId(first + k_next[next.edge]), LeafId(first + next.edge)};
}

CellTriangle TriangleForest::triangle(LeafId leaf) const {
    const Frame f = frame(leaf.value);
    const std::uint32_t step = f.is_reversed ? ~std::uint32_t{0} : 1;
    return {HalfedgeId(3 * f.face), f.level, {f.at, {f.at.x + step, f.at.y}, {f.at.x, f.at.y + step}}};
}

std::array<PointId, 3> TriangleForest::points(LeafId leaf) const {
    const auto p = corners(leaf.value);
    return {PointId(p[0]), PointId(p[1]), PointId(p[2])};
}

std::array<PointId, 3> TriangleForest::hanging_points(LeafId leaf) const {
    return {PointId(hanging_point(leaf.value, 0)), PointId(hanging_point(leaf.value, 1)),
            PointId(hanging_point(leaf.value, 2))};
}

std::uint64_t TriangleForest::memory_bytes() const {
    return records_.capacity() * sizeof(Record) + sites_.capacity() * sizeof(Site) + marks_.capacity() +
           (root_link_.capacity() + child_.capacity() + free_records_.capacity() + free_points_.capacity()) *
               sizeof(std::uint32_t) +
           mesh_->vertex_count() * sizeof(std::uint32_t);  // canonical_
}

void TriangleForest::shrink() {
    child_.shrink_to_fit();
    records_.shrink_to_fit();
    sites_.shrink_to_fit();
    free_records_.shrink_to_fit();
    free_points_.shrink_to_fit();
    marks_.shrink_to_fit();
}

void TriangleForest::require_leaves(std::span<const LeafId> leaves) const {
    for (const LeafId leaf : leaves)
        if (!is_leaf(leaf))
            throw Error(ErrorCode::invalid_input,
                        "triangle " + std::to_string(leaf.value) +
                            " is not a leaf of the forest (any more): it was split or merged, or never existed");
}

}  // namespace tetrakis
