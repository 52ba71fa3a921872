#include "tetrakis/hier/triangle_forest.hpp"

#include "tetrakis/hier/error.hpp"

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
            if (!site.root.valid()) ++point_count_;
            site = canonical_.vertex(mesh.origin(h));
        }
    }
}

TriangleForest::Neighbour TriangleForest::neighbour(std::uint32_t slot, std::uint32_t edge) const {
    if (slot < root_count_) {
        const std::uint32_t link = root_link_[3 * std::size_t{slot} + edge];
        return link == k_boundary ? Neighbour{k_boundary, 0} : Neighbour{link / 4, link % 4};
    }
    const std::uint32_t record = (slot - root_count_) / 4, child = (slot - root_count_) % 4;
    // The middle child's edge e is the inner edge of the child at the corner that e does not touch.
    if (child == 3) return {first_child(record) + (edge + 2) % 3, edge};
    if (edge == (child + 1) % 3) return {first_child(record) + 3, edge};
    const std::uint32_t link = records_[record].link[edge];
    if (link >= k_boundary) return {link, 0};
    // Edge e's first half belongs to child e, its second half to child e + 1; seen from the other side they are
    // swapped.
    const std::uint32_t other = link % 4;
    return {first_child(link / 4) + (edge == child ? (other + 1) % 3 : other), other};
}

TriangleForest::Frame TriangleForest::frame(std::uint32_t slot) const {
    if (slot < root_count_) return {slot, {0, 0}, 0, 0};
    const Record& record = records_[(slot - root_count_) / 4];
    const std::uint32_t child = (slot - root_count_) % 4;
    const std::uint32_t step = record.is_reversed ? ~std::uint32_t{0} : 1;
    LatticePoint at{2 * record.at.x, 2 * record.at.y};
    if (child == 1 || child == 3) at.x += step;
    if (child == 2 || child == 3) at.y += step;
    return {record.face, at, static_cast<std::uint8_t>(record.level + 1),
            static_cast<std::uint8_t>(child == 3 ? !record.is_reversed : record.is_reversed)};
}

std::array<std::uint32_t, 3> TriangleForest::corners(std::uint32_t slot) const {
    if (slot < root_count_) {
        const HalfedgeId h(3 * slot);
        return {mesh_->origin(h).value, mesh_->origin(HalfedgeId(h.value + 1)).value,
                mesh_->origin(HalfedgeId(h.value + 2)).value};
    }
    const auto& p = records_[(slot - root_count_) / 4].point;
    switch ((slot - root_count_) % 4) {
        case 0:
            return {p[0], p[3], p[5]};
        case 1:
            return {p[3], p[1], p[4]};
        case 2:
            return {p[5], p[4], p[2]};
        default:
            return {p[4], p[5], p[3]};
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

void TriangleForest::require_leaves(std::span<const LeafId> leaves) const {
    for (const LeafId leaf : leaves)
        if (!is_leaf(leaf))
            throw Error(ErrorCode::invalid_input,
                        "triangle " + std::to_string(leaf.value) +
                            " is not a leaf of the forest (any more): it was split or merged, or never existed");
}

}  // namespace tetrakis
