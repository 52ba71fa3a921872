#include "bisection_forest.hpp"

#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "../base/parallel.hpp"
#include "exported_triangles.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <bit>
#include <numeric>
#include <span>
#include <string>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_records_ahead = 16;  // prefetch distance in records: the loop waits for memory

}  // namespace

// Leaves are disjoint, so their paths differ within the shorter one and compare as left-aligned numbers. They are
// sorted in buckets by root and the first bits of the path.
std::vector<LeafId> BisectionForest::ordered_leaves() const {
    constexpr std::uint32_t k_leaves = 32;  // in a bucket, about
    const std::uint32_t roots = mesh_->halfedge_count();
    const int bits = std::bit_width(leaf_count_ / k_leaves / std::max(roots, 1u));
    const auto path_of = [&](LeafId id) { return leaves_[id.value].path << (63 - leaves_[id.value].depth); };
    const auto for_each_leaf = [&](auto&& visit) {
        for (LeafId id(0); id.value < leaf_slots(); ++id.value)
            if (is_leaf(id)) visit(id, (std::size_t{root(id).value} << bits) + (path_of(id) >> (63 - bits)));
    };
    const std::size_t buckets = std::size_t{roots} << bits;
    detail::PoolVector<std::uint32_t> begin(buckets + 2, 0);
    for_each_leaf([&](LeafId, std::size_t bucket) { ++begin[bucket + 2]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<LeafId> order;
    detail::resize_large(order, leaf_count_);
    for_each_leaf([&](LeafId id, std::size_t bucket) { order[begin[bucket + 1]++] = id; });
    constexpr std::uint32_t k_buckets_per_task = 512;
    for_each_index(
        static_cast<std::uint32_t>(buckets),
        [&](std::uint32_t b) {
            oneapi::tbb::parallel_sort(order.begin() + begin[b], order.begin() + begin[b + 1],
                                       [&](LeafId p, LeafId q) { return path_of(p) < path_of(q); });
        },
        k_buckets_per_task);
    return order;
}

ExportedTriangles BisectionForest::exported(const FanChoice& fans, std::span<const std::uint8_t> use) const {
    const ControlMesh& mesh = *mesh_;
    if (!use.empty() && use.size() != mesh.face_count())
        throw Error(ErrorCode::invalid_input, "there are " + std::to_string(use.size()) + " fan flags for " +
                                                  std::to_string(mesh.face_count()) + " faces");
    const auto is_fan = [&](FaceId f) {
        if (use[f.value] == 0) return false;
        if (!fans.has(f))
            throw Error(ErrorCode::invalid_input, "face " + std::to_string(f.value) + " has no fan to be output");
        const std::uint32_t h = mesh.face_halfedge(f).value;
        for (std::uint32_t i = 0; i < mesh.face_size(f); ++i)
            if (!root_leaf(HalfedgeId(h + i)).valid()) return false;
        return true;
    };
    ExportedTriangles out;
    detail::reserve_large(out.triangles, leaf_count_);
    detail::reserve_large(out.faces, leaf_count_);
    detail::reserve_large(out.leaves, leaf_count_);
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, FaceId f, LeafId leaf) {
        out.triangles.push_back({a, b, c});
        out.faces.push_back(f);
        out.leaves.push_back(leaf);
    };
    // Corners are point handles here; number_points() replaces them by numbers below.
    const std::vector<LeafId> order = ordered_leaves();
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (i + k_records_ahead < order.size()) __builtin_prefetch(&leaves_[order[i + k_records_ahead].value].vertex);
        const BisectionLeaf& l = leaves_[order[i].value];
        const FaceId f = mesh.face(l.cell);
        if (!use.empty() && l.cell == mesh.face_halfedge(f) && is_fan(f)) {
            const auto vertex = [&](std::uint8_t corner) {
                return mesh.origin(HalfedgeId(l.cell.value + corner)).value;
            };
            for (const auto& [a, b, c] : fans.of(f)) add(vertex(a), vertex(b), vertex(c), f, {});
            i += mesh.face_size(f) - 1;  // the face's roots follow each other in `order`
        } else {
            add(l.vertex[0].value, l.vertex[1].value, l.vertex[2].value, f, order[i]);
        }
    }
    detail::number_points(out, *this, mesh.vertex_count() + mesh.face_count() + std::size_t{midpoint_count_});
    return out;
}

}  // namespace tetrakis
