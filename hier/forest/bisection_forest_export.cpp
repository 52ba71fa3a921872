#include "bisection_forest.hpp"

#include "../base/error.hpp"
#include "../base/memory.hpp"
#include "../base/parallel.hpp"
#include "exported_triangles.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <span>
#include <string>

namespace tetrakis {

namespace {

constexpr std::uint32_t k_records_ahead = 16;  // records asked for ahead of time: the loops wait for memory

constexpr std::uint32_t k_free = LeafId::none;

struct Key {
    std::uint64_t path;  // its bits at the upper end
    std::uint32_t slot;
    bool operator<(const Key& o) const { return path < o.path; }
};

/// The leaves of a root: how many, and the greatest depth.
struct RootLeaves {
    std::uint32_t count = 0;
    int deepest = 0;

    std::uint64_t nodes() const { return std::uint64_t{1} << deepest; }
    /// Whether its leaves are put in order by the places that they have among all nodes of the greatest depth. Not
    /// where there are many more of these than leaves.
    bool has_places() const { return deepest < 32 && nodes() <= 4 * std::uint64_t{count}; }
};

}  // namespace

// Slots of all leaves by root, then by path. Leaves are disjoint, so their paths differ within the shorter one and
// compare as left-aligned numbers.
detail::PoolVector<std::uint32_t> BisectionForest::leaves_in_order() const {
    const std::uint32_t slots = leaf_slots(), roots = mesh_->halfedge_count();
    detail::PoolVector<RootLeaves> of_root(roots);
    for (std::uint32_t s = 0; s < slots; ++s) {
        const BisectionLeaf& l = leaves_[s];
        if (l.depth == k_dead) continue;
        RootLeaves& of = of_root[root(LeafId(s)).value];
        ++of.count;
        of.deepest = std::max<int>(of.deepest, l.depth);
    }
    // Where a root's leaves go: places of its own, or keys to be sorted; and in the end.
    detail::PoolVector<std::uint64_t> first(roots);
    detail::PoolVector<std::uint32_t> first_in_order(roots + std::size_t{1}, 0);
    std::uint64_t place_count = 0, key_count = 0;
    for (std::uint32_t r = 0; r < roots; ++r) {
        const RootLeaves& of = of_root[r];
        std::uint64_t& count = of.has_places() ? place_count : key_count;
        first[r] = count;
        count += of.has_places() ? of.nodes() : of.count;
        first_in_order[r + 1] = first_in_order[r] + of.count;
    }
    detail::PoolVector<std::uint32_t> places(place_count, k_free);
    std::vector<Key> keys;  // of no pool: large, and what comes next must fit beside what is kept of it
    detail::resize_large(keys, key_count);
    detail::PoolVector<std::uint64_t> next_key(first.begin(), first.end());
    for (std::uint32_t s = 0; s < slots; ++s) {
        const BisectionLeaf& l = leaves_[s];
        if (l.depth == k_dead) continue;
        const std::uint32_t r = root(LeafId(s)).value;
        if (of_root[r].has_places())
            places[first[r] + (l.path << (of_root[r].deepest - l.depth))] = s;
        else
            keys[next_key[r]++] = {l.depth == 0 ? 0 : l.path << (64 - l.depth), s};
    }
    constexpr std::uint32_t k_roots_per_task = 64;
    constexpr std::uint32_t k_large_root = 1u << 16;  // worth a parallel sort of its own
    const auto keys_of = [&](std::uint32_t r) { return std::span(keys.data() + first[r], of_root[r].count); };
    for (std::uint32_t r = 0; r < roots; ++r)
        if (!of_root[r].has_places() && of_root[r].count >= k_large_root)
            oneapi::tbb::parallel_sort(keys_of(r).begin(), keys_of(r).end());
    detail::PoolVector<std::uint32_t> order;
    detail::resize_large(order, leaf_count_);
    for_each_block(roots, k_roots_per_task, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t r = begin; r < end; ++r) {
            std::uint32_t* to = order.data() + first_in_order[r];
            if (of_root[r].has_places()) {
                for (std::uint64_t i = first[r]; i < first[r] + of_root[r].nodes(); ++i)
                    if (places[i] != k_free) *to++ = places[i];
                continue;
            }
            if (of_root[r].count < k_large_root) std::sort(keys_of(r).begin(), keys_of(r).end());
            for (const Key& key : keys_of(r)) *to++ = key.slot;
        }
    });
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
    ExportedTriangles out;
    export_to(out, fans, use);
    return out;
}

detail::PooledTriangles BisectionForest::pooled() const {
    detail::PooledTriangles out;
    export_to(out, {}, {});
    return out;
}

template <class Exported>
void BisectionForest::export_to(Exported& out, const FanChoice& fans, std::span<const std::uint8_t> use) const {
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
            if (i + k_records_ahead < leaf_count_) __builtin_prefetch(&leaves_[order[i + k_records_ahead]].vertex);
            put_leaf(i, order[i]);
        });
    } else {
        std::size_t t = 0;
        for (std::uint32_t i = 0; i < leaf_count_;) {
            if (i + k_records_ahead < leaf_count_) __builtin_prefetch(&leaves_[order[i + k_records_ahead]].vertex);
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
}

}  // namespace tetrakis
