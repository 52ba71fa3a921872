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

// Leaves are disjoint, so their paths differ within the shorter one and compare as left-aligned numbers. A root has a
// bucket per leaf or more, by the first bits of the path; leaves of one depth get a bucket each.
std::vector<LeafId> BisectionForest::ordered_leaves() const {
    struct Key {
        std::uint64_t path;  // its bits at the upper end
        LeafId leaf;
        bool operator<(const Key& o) const { return path < o.path; }
    };
    const std::uint32_t roots = mesh_->halfedge_count();
    const auto for_each_leaf = [&](auto&& visit) {
        for (LeafId id(0); id.value < leaf_slots(); ++id.value)
            if (is_leaf(id)) visit(id, root(id).value);
    };
    detail::PoolVector<std::uint64_t> count(roots, 0), first_bucket(roots + std::size_t{1}, 0);
    for_each_leaf([&](LeafId, std::uint32_t root) { ++count[root]; });
    for (std::uint32_t r = 0; r < roots; ++r) first_bucket[r + 1] = first_bucket[r] + std::bit_ceil(count[r]);
    const auto path_of = [&](LeafId id) { return leaves_[id.value].path << (63 - leaves_[id.value].depth) << 1; };
    const auto bucket_of = [&](LeafId id, std::uint32_t root) {
        const int bits = std::countr_zero(std::bit_ceil(count[root]));
        return first_bucket[root] + (path_of(id) >> 1 >> (63 - bits));
    };
    detail::PoolVector<std::uint32_t> begin(first_bucket[roots] + std::size_t{1}, 0);
    for_each_leaf([&](LeafId id, std::uint32_t root) { ++begin[bucket_of(id, root) + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Key> keys;  // no PoolVector: the pool would keep this large block during the next allocation
    detail::resize_large(keys, leaf_count_);
    detail::PoolVector<std::uint32_t> end(begin.begin(), begin.end() - 1);
    for_each_leaf([&](LeafId id, std::uint32_t root) { keys[end[bucket_of(id, root)]++] = {path_of(id), id}; });
    constexpr std::uint32_t k_roots_per_task = 64;
    for_each_block(roots, k_roots_per_task, [&](std::uint32_t first, std::uint32_t last) {
        for (std::uint64_t b = first_bucket[first]; b < first_bucket[last]; ++b)
            if (end[b] - begin[b] > 1) oneapi::tbb::parallel_sort(keys.begin() + begin[b], keys.begin() + end[b]);
    });
    std::vector<LeafId> order;
    detail::reserve_large(order, leaf_count_);
    for (const Key& key : keys) order.push_back(key.leaf);
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
