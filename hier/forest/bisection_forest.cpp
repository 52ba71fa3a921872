#include "bisection_forest.hpp"

#include "../base/error.hpp"
#include "../base/parallel.hpp"
#include "corner_cell.hpp"

#include <algorithm>
#include <string>

namespace tetrakis {

BisectionForest::BisectionForest(const ControlMesh& mesh) : mesh_(&mesh) {
    const std::uint64_t points = std::uint64_t{mesh.vertex_count()} + mesh.face_count();
    if (points >= PointId::none)
        throw Error(ErrorCode::memory_limit, "a mesh with " + std::to_string(mesh.vertex_count()) + " vertices and " +
                                                 std::to_string(mesh.face_count()) +
                                                 " faces has more points than can be numbered; split it");
    leaves_.resize(mesh.halfedge_count());
    sites_.resize(static_cast<std::size_t>(points));
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
                      .direction = shape.direction};
    });
    for_each_index(mesh.vertex_count(), [&](std::uint32_t v) {
        const HalfedgeId h = mesh.vertex_halfedge(VertexId(v));
        sites_[v] = h.valid() ? canonical(mesh, {h, {0, 0}, 0}) : Site{};
    });
    for_each_index(mesh.face_count(), [&](std::uint32_t f) {
        sites_[mesh.vertex_count() + f] = {mesh.face_halfedge(FaceId(f)), {1, 1}, 0};
    });
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (!mesh.is_hole(FaceId(f))) leaf_count_ += mesh.face_size(FaceId(f));
}

std::uint64_t BisectionForest::memory_bytes() const {
    return leaves_.capacity() * sizeof(BisectionLeaf) + sites_.capacity() * sizeof(Site) +
           (free_leaves_.capacity() + free_points_.capacity() + scratch_.listed.capacity() +
            scratch_.affected.capacity() + scratch_.created.capacity()) *
               sizeof(std::uint32_t) +
           scratch_.work.capacity() * sizeof(Work);
}

void BisectionForest::shrink() {
    scratch_ = Scratch();
    leaves_.shrink_to_fit();
    sites_.shrink_to_fit();
    free_leaves_.shrink_to_fit();
    free_points_.shrink_to_fit();
}

void BisectionForest::require_leaves(std::span<const LeafId> ids) const {
    constexpr std::size_t k_ahead = 24;  // records asked for ahead of time: the loop waits for memory
    for (std::size_t i = 0; i < ids.size(); ++i) {
        if (i + k_ahead < ids.size() && ids[i + k_ahead].value < leaves_.size())
            __builtin_prefetch(&leaves_[ids[i + k_ahead].value].depth);
        const LeafId id = ids[i];
        if (!is_leaf(id))
            throw Error(ErrorCode::invalid_input,
                        id.value < leaves_.size()
                            ? "slot " + std::to_string(id.value) + " holds no leaf: it was merged, or is a hole's"
                            : "leaf " + std::to_string(id.value) + " is beyond the forest's " +
                                  std::to_string(leaves_.size()) + " slots");
    }
}

void BisectionForest::grow_work(std::size_t slots) {
    const std::size_t old = scratch_.work.size();
    if (slots <= old) return;
    scratch_.work.resize(slots);
    // Mostly the first touch of fresh pages.
    constexpr std::uint32_t k_block = 1u << 15;
    for_each_block(static_cast<std::uint32_t>(slots - old), k_block, [&](std::uint32_t begin, std::uint32_t end) {
        std::fill(scratch_.work.data() + old + begin, scratch_.work.data() + old + end, Work{});
    });
}

void BisectionForest::clear_work() {
    std::fill(scratch_.work.data(), scratch_.work.data() + scratch_.work.size(), Work{});
}

}  // namespace tetrakis
