#include "tetrakis/hier/bisection_forest.hpp"

#include "tetrakis/hier/error.hpp"
#include "tetrakis/hier/parallel.hpp"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <string>

namespace tetrakis {

// Slots of all leaves by root, then by path. Leaves are disjoint, so their paths differ within the shorter one and
// compare as left-aligned numbers.
std::vector<std::uint32_t> BisectionForest::leaves_in_order() const {
    const std::uint32_t slots = leaf_slots(), roots = mesh_->halfedge_count();
    std::vector<std::uint32_t> first(roots + 1, 0);
    for (std::uint32_t s = 0; s < slots; ++s)
        if (leaves_[s].depth != k_dead) ++first[root(LeafId(s)).value + 1];
    for (std::uint32_t r = 0; r < roots; ++r) first[r + 1] += first[r];

    struct Key {
        std::uint64_t path;
        std::uint32_t slot;
        bool operator<(const Key& o) const { return path < o.path; }
    };
    std::vector<Key> keys(leaf_count_);
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::uint32_t s = 0; s < slots; ++s) {
        const BisectionLeaf& l = leaves_[s];
        if (l.depth == k_dead) continue;
        const std::uint64_t aligned = l.depth == 0 ? 0 : l.path << (64 - l.depth);
        keys[next[root(LeafId(s)).value]++] = {aligned, s};
    }
    constexpr std::uint32_t k_roots_per_task = 64;
    constexpr std::uint32_t k_large_root = 1u << 16;  // worth a parallel sort of its own
    for_each_index(
        roots,
        [&](std::uint32_t r) {
            if (const auto count = first[r + 1] - first[r]; count >= 2 && count < k_large_root)
                std::sort(keys.begin() + first[r], keys.begin() + first[r + 1]);
        },
        k_roots_per_task);
    for (std::uint32_t r = 0; r < roots; ++r)
        if (first[r + 1] - first[r] >= k_large_root)
            oneapi::tbb::parallel_sort(keys.begin() + first[r], keys.begin() + first[r + 1]);
    std::vector<std::uint32_t> order(leaf_count_);
    for_each_index(leaf_count_, [&](std::uint32_t i) { order[i] = keys[i].slot; });
    return order;
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
    const std::vector<std::uint32_t> order = leaves_in_order();
    ExportedTriangles out;
    out.triangles.reserve(leaf_count_);
    out.faces.reserve(leaf_count_);
    out.leaves.reserve(leaf_count_);
    std::vector<std::uint32_t> dense(sites_.size(), PointId::none);
    const auto number = [&](PointId p) {
        std::uint32_t& n = dense[p.value];
        if (n == PointId::none) {
            n = static_cast<std::uint32_t>(out.points.size());
            out.points.push_back(p);
            out.sites.push_back(sites_[p.value]);
        }
        return n;
    };
    for (std::size_t i = 0; i < order.size();) {
        const BisectionLeaf& l = leaves_[order[i]];
        const FaceId f = mesh.face(l.cell);
        if (l.depth == 0 && l.cell == mesh.face_halfedge(f) && is_fan(f)) {
            for (const auto& corner : fans.of(f)) {
                std::array<std::uint32_t, 3> t;
                for (std::size_t k = 0; k < 3; ++k)
                    t[k] = number(vertex_point(mesh.origin(HalfedgeId(l.cell.value + corner[k]))));
                out.triangles.push_back(t);
                out.faces.push_back(f);
                out.leaves.push_back(LeafId{});
            }
            i += mesh.face_size(f);  // its roots follow each other
            continue;
        }
        std::array<std::uint32_t, 3> t;
        for (std::size_t k = 0; k < 3; ++k) t[k] = number(l.vertex[k]);
        out.triangles.push_back(t);
        out.faces.push_back(f);
        out.leaves.push_back(LeafId(order[i]));
        ++i;
    }
    return out;
}

}  // namespace tetrakis
