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

// Leaves are disjoint, so their paths differ within the shorter one and compare as left-aligned numbers.
std::vector<LeafId> BisectionForest::ordered_leaves() const {
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
    std::vector<LeafId> order;
    detail::resize_large(order, leaf_count_);
    for_each_block(roots, k_roots_per_task, [&](std::uint32_t begin, std::uint32_t end) {
        for (std::uint32_t r = begin; r < end; ++r) {
            LeafId* to = order.data() + first_in_order[r];
            if (of_root[r].has_places()) {
                for (std::uint64_t i = first[r]; i < first[r] + of_root[r].nodes(); ++i)
                    if (places[i] != k_free) *to++ = LeafId(places[i]);
                continue;
            }
            if (of_root[r].count < k_large_root) std::sort(keys_of(r).begin(), keys_of(r).end());
            for (const Key& key : keys_of(r)) *to++ = LeafId(key.slot);
        }
    });
    return order;
}

ExportedTriangles BisectionForest::exported() const { return exported(FanChoice{}, {}); }

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
    // Corners as points, to be numbered afterwards.
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
            i += mesh.face_size(f) - 1;  // its roots follow each other
        } else {
            add(l.vertex[0].value, l.vertex[1].value, l.vertex[2].value, f, order[i]);
        }
    }
    detail::number_points(out, *this, mesh.vertex_count() + mesh.face_count() + std::size_t{midpoint_count_});
    return out;
}

}  // namespace tetrakis
