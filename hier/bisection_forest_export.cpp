#include "tetrakis/hier/bisection_forest.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/huge_memory.hpp"
#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/hier/point_numbers.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <string>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_ahead = 16;  // records asked for ahead of time: the loops wait for memory

struct Key {
    std::uint64_t path;  // its bits at the upper end
    std::uint32_t slot;
    bool operator<(const Key& o) const { return path < o.path; }
};

/// Sorts the leaves of a root whose depths hardly differ: each has its place among all nodes of the deepest level.
/// False, and nothing is done, where that has many more of them.
bool put_in_place(std::span<Key> keys, std::vector<std::uint32_t>& places) {
    constexpr std::uint32_t k_free = 0xFFFF'FFFFu;
    std::uint64_t all = 0;
    for (const Key& key : keys) all |= key.path;
    const int shift = std::countr_zero(all);
    const std::size_t nodes = std::size_t{1} << std::min(64 - shift, 40);
    if (nodes > 4 * keys.size()) return false;
    places.assign(nodes, k_free);
    for (const Key& key : keys) places[key.path >> shift] = key.slot;
    std::size_t next = 0;
    for (std::size_t node = 0; node < nodes; ++node)
        if (places[node] != k_free) keys[next++] = {std::uint64_t{node} << shift, places[node]};
    return true;
}

}  // namespace

// Slots of all leaves by root, then by path. Leaves are disjoint, so their paths differ within the shorter one and
// compare as left-aligned numbers.
detail::PoolVector<std::uint32_t> BisectionForest::leaves_in_order() const {
    const std::uint32_t slots = leaf_slots(), roots = mesh_->halfedge_count();
    detail::PoolVector<std::uint32_t> first(roots + 1, 0);
    for (std::uint32_t s = 0; s < slots; ++s)
        if (leaves_[s].depth != k_dead) ++first[root(LeafId(s)).value + 1];
    for (std::uint32_t r = 0; r < roots; ++r) first[r + 1] += first[r];

    std::vector<Key> keys;  // of no pool: large, and what comes next must fit beside what is kept of it
    detail::resize_large(keys, leaf_count_);
    detail::PoolVector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t s = 0; s < slots; ++s) {
        const BisectionLeaf& l = leaves_[s];
        if (l.depth == k_dead) continue;
        const std::uint64_t aligned = l.depth == 0 ? 0 : l.path << (64 - l.depth);
        keys[next[root(LeafId(s)).value]++] = {aligned, s};
    }
    constexpr std::uint32_t k_roots_per_task = 64;
    constexpr std::uint32_t k_large_root = 1u << 16;  // worth a parallel sort of its own
    for_each_block(roots, k_roots_per_task, [&](std::uint32_t begin, std::uint32_t end) {
        std::vector<std::uint32_t> places;
        for (std::uint32_t r = begin; r < end; ++r) {
            const std::span<Key> of_root(keys.data() + first[r], first[r + 1] - first[r]);
            if (of_root.size() < 2 || of_root.size() >= k_large_root || put_in_place(of_root, places)) continue;
            std::sort(of_root.begin(), of_root.end());
        }
    });
    for (std::uint32_t r = 0; r < roots; ++r)
        if (first[r + 1] - first[r] >= k_large_root)
            oneapi::tbb::parallel_sort(keys.begin() + first[r], keys.begin() + first[r + 1]);
    detail::PoolVector<std::uint32_t> order;
    detail::resize_large(order, leaf_count_);
    for_each_index(leaf_count_, [&](std::uint32_t i) { order[i] = keys[i].slot; });
    return order;
}

std::vector<LeafId> BisectionForest::ordered_leaves() const {
    const detail::PoolVector<std::uint32_t> order = leaves_in_order();
    std::vector<LeafId> leaves;
    detail::resize_large(leaves, order.size());
    for_each_index(leaf_count_, [&](std::uint32_t i) { leaves[i] = LeafId(order[i]); });
    return leaves;
}

ExportedTriangles BisectionForest::exported() const { return exported(FanChoice{}, {}); }

ExportedTriangles BisectionForest::exported(const FanChoice& fans, std::span<const std::uint8_t> use) const {
    const ControlMesh& mesh = *mesh_;
    if (!use.empty() && use.size() != mesh.face_count())
        throw Error(ErrorCode::invalid_input, "there are " + std::to_string(use.size()) + " fan flags for " +
                                                  std::to_string(mesh.face_count()) + " faces");
    const auto is_fan = [&](FaceId f) {
        if (use.empty() || use[f.value] == 0 || mesh.is_hole(f)) return false;
        if (!fans.has(f))
            throw Error(ErrorCode::invalid_input, "face " + std::to_string(f.value) + " has no fan to be output");
        const std::uint32_t h = mesh.face_halfedge(f).value;
        for (std::uint32_t i = 0; i < mesh.face_size(f); ++i)
            if (!root_leaf(HalfedgeId(h + i)).valid()) return false;
        return true;
    };
    const detail::PoolVector<std::uint32_t> order = leaves_in_order();
    // Fans take their place among the leaves first; all else is then the same for both.
    ExportedTriangles out;
    std::vector<std::uint8_t> fan_face;
    std::uint64_t triangle_count = leaf_count_;
    if (!use.empty()) {
        fan_face.resize(mesh.face_count());
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            fan_face[f] = is_fan(FaceId(f));
            triangle_count -= 2 * fan_face[f];
        }
    }
    detail::resize_large(out.triangles, triangle_count);
    detail::resize_large(out.faces, triangle_count);
    detail::resize_large(out.leaves, triangle_count);
    // Corners as points, to be numbered afterwards.
    const auto put_leaf = [&](std::size_t t, std::uint32_t slot) {
        const BisectionLeaf& l = leaves_[slot];
        out.triangles[t] = {l.vertex[0].value, l.vertex[1].value, l.vertex[2].value};
        out.faces[t] = mesh.face(l.cell);
        out.leaves[t] = LeafId(slot);
    };
    if (triangle_count == leaf_count_) {
        for_each_index(leaf_count_, [&](std::uint32_t i) {
            if (i + k_ahead < leaf_count_) __builtin_prefetch(&leaves_[order[i + k_ahead]].vertex);
            put_leaf(i, order[i]);
        });
    } else {
        std::size_t t = 0;
        for (std::uint32_t i = 0; i < leaf_count_;) {
            if (i + k_ahead < leaf_count_) __builtin_prefetch(&leaves_[order[i + k_ahead]].vertex);
            const BisectionLeaf& l = leaves_[order[i]];
            const FaceId f = mesh.face(l.cell);
            if (fan_face[f.value] == 0) {
                put_leaf(t++, order[i++]);
                continue;
            }
            for (const auto& corner : fans.of(f)) {
                for (std::size_t k = 0; k < 3; ++k)
                    out.triangles[t][k] = mesh.origin(HalfedgeId(l.cell.value + corner[k])).value;
                out.faces[t++] = f;
            }
            i += mesh.face_size(f);  // its roots follow each other, the first one first
        }
    }
    detail::number_points(out, sites_.size(), mesh.vertex_count() + mesh.face_count() + std::size_t{midpoint_count_});
    detail::resize_large(out.sites, out.points.size());
    for_each_index(static_cast<std::uint32_t>(out.points.size()),
                   [&](std::uint32_t p) { out.sites[p] = sites_[out.points[p].value]; });
    return out;
}

}  // namespace tetrakis
