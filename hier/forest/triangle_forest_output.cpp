#include "../base/memory.hpp"
#include "../base/parallel.hpp"
#include "point_numbers.hpp"
#include "triangle_forest.hpp"

#include <algorithm>

namespace tetrakis {

namespace {

// Corners of a leaf's output triangles: 0, 1, 2 are its own, 3 + e is the midpoint of edge e.
struct GreenPattern {
    std::uint8_t count = 1;
    std::uint8_t corner[4][3] = {{0, 1, 2}, {}, {}, {}};
};

// By the set of edges with a hanging midpoint. With two of them the ear between is cut off, and the quadrilateral that
// is left has its diagonal from the corner at the end of the whole edge: a rule that knows only the leaf's own frame,
// so that the pattern is the same whatever happened before. With all three they are the leaf's children, as corners()
// has them.
constexpr std::array<GreenPattern, 8> make_patterns() {
    std::array<GreenPattern, 8> pattern{};
    for (unsigned e = 0; e < 3; ++e) {
        const auto a = static_cast<std::uint8_t>(e), b = static_cast<std::uint8_t>((e + 1) % 3),
                   c = static_cast<std::uint8_t>((e + 2) % 3);
        const auto m = static_cast<std::uint8_t>(3 + a), n = static_cast<std::uint8_t>(3 + b);
        pattern[1u << a] = {2, {{a, m, c}, {m, b, c}, {}, {}}};
        pattern[1u << a | 1u << b] = {3, {{m, b, n}, {a, m, n}, {a, n, c}, {}}};
    }
    pattern[7] = {4, {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {4, 5, 3}}};
    return pattern;
}

constexpr std::array<GreenPattern, 8> k_patterns = make_patterns();

}  // namespace

std::uint32_t TriangleForest::hanging_mask(std::uint32_t slot) const {
    std::uint32_t mask = 0;
    for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t next = neighbour(slot, e).slot;
        if (next < k_boundary && is_split(next)) mask |= 1u << e;
    }
    return mask;
}

GreenTriangles TriangleForest::green_triangles(LeafId leaf) const {
    const CellTriangle whole = triangle(leaf);
    const auto own = points(leaf);
    const std::uint32_t mask = hanging_mask(leaf.value);
    GreenTriangles green;
    if (mask == 0) {
        green.count = 1;
        green.cell[0] = whole;
        green.point[0] = own;
        return green;
    }
    std::array<LatticePoint, 6> at;
    std::array<PointId, 6> point;
    for (std::uint32_t e = 0; e < 3; ++e) {
        const LatticePoint p = whole.corner[e], q = whole.corner[(e + 1) % 3];
        at[e] = {2 * p.x, 2 * p.y};
        at[3 + e] = {p.x + q.x, p.y + q.y};
        point[e] = own[e];
        if (mask >> e & 1) point[3 + e] = PointId(hanging_point(leaf.value, e));
    }
    const GreenPattern& pattern = k_patterns[mask];
    green.count = pattern.count;
    for (int t = 0; t < green.count; ++t) {
        green.cell[t].root = whole.root;
        green.cell[t].level = static_cast<std::uint8_t>(whole.level + 1);
        for (int k = 0; k < 3; ++k) {
            green.cell[t].corner[k] = at[pattern.corner[t][k]];
            green.point[t][k] = point[pattern.corner[t][k]];
        }
    }
    return green;
}

// hanging_mask() of the four children at once; means nothing for those that are split.
std::array<std::uint8_t, 4> TriangleForest::child_masks(std::uint32_t record) const {
    std::array<std::uint8_t, 4> mask{};
    const std::uint32_t first = first_child(record);
    for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t link = records_[record].link[e], next = (e + 1) % 3;
        if (link < k_boundary) {
            const std::uint32_t other = first_child(link / 4), edge = link % 4;
            if (is_split(other + (edge + 1) % 3)) mask[e] |= static_cast<std::uint8_t>(1u << e);
            if (is_split(other + edge)) mask[next] |= static_cast<std::uint8_t>(1u << e);
        }
        if (is_split(first + 3)) mask[e] |= static_cast<std::uint8_t>(1u << next);
        if (is_split(first + e)) mask[3] |= static_cast<std::uint8_t>(1u << next);
    }
    return mask;
}

// The leaves of some roots, depth first with children by their numbers: the order of (root, path).
struct TriangleForest::LeafRun {
    detail::PoolVector<std::uint32_t> slots;
    detail::PoolVector<std::uint8_t> masks;
    std::size_t triangles = 0, first_triangle = 0;

    void add(std::uint32_t slot, std::uint8_t mask) {
        slots.push_back(slot);
        masks.push_back(mask);
        triangles += k_patterns[mask].count;
    }
};

void TriangleForest::append_leaves(std::uint32_t record, LeafRun& run) const {
    const auto masks = child_masks(record);
    for (std::uint32_t k = 0; k < 4; ++k) {
        const std::uint32_t slot = first_child(record) + k;
        if (is_split(slot))
            append_leaves(child_[slot], run);
        else
            run.add(slot, masks[k]);
    }
}

template <class Exported>
void TriangleForest::write_run(const LeafRun& run, Exported& out) const {
    std::size_t place = run.first_triangle;
    for (std::size_t i = 0; i < run.slots.size(); ++i) {
        const std::uint32_t slot = run.slots[i], mask = run.masks[i];
        const auto own = corners(slot);
        std::array<std::uint32_t, 6> point{own[0], own[1], own[2], 0, 0, 0};
        for (std::uint32_t e = 0; e < 3; ++e)
            if (mask >> e & 1) point[3 + e] = hanging_point(slot, e);
        const FaceId f = face(LeafId(slot));
        const GreenPattern& pattern = k_patterns[mask];
        for (std::uint32_t t = 0; t < pattern.count; ++t, ++place) {
            for (int k = 0; k < 3; ++k) out.triangles[place][k] = point[pattern.corner[t][k]];
            out.faces[place] = f;
            out.leaves[place] = LeafId(slot);
        }
    }
}

// The roots in runs that are equally long in roots, with the leaves of each.
std::vector<TriangleForest::LeafRun> TriangleForest::leaf_runs() const {
    // Enough runs for any number of threads to be busy, few enough for their vectors not to matter.
    constexpr std::uint32_t max_runs = 256;
    const std::uint32_t run_count = std::min(root_count_, max_runs);
    std::vector<LeafRun> runs(run_count);
    for_each_index(
        run_count,
        [&](std::uint32_t i) {
            const auto bound = [&](std::uint64_t n) { return static_cast<std::uint32_t>(n * root_count_ / run_count); };
            for (std::uint32_t f = bound(i); f < bound(i + 1); ++f) {
                if (is_split(f))
                    append_leaves(child_[f], runs[i]);
                else if (child_[f] == k_unsplit)
                    runs[i].add(f, static_cast<std::uint8_t>(hanging_mask(f)));
            }
        },
        1);
    return runs;
}

std::vector<LeafId> TriangleForest::ordered_leaves() const {
    std::vector<LeafId> leaves;
    detail::reserve_large(leaves, leaf_count_);
    for (const LeafRun& run : leaf_runs())
        for (std::uint32_t slot : run.slots) leaves.push_back(LeafId(slot));
    return leaves;
}

ExportedTriangles TriangleForest::exported() const {
    ExportedTriangles out;
    export_to(out);
    return out;
}

detail::PooledTriangles TriangleForest::pooled() const {
    detail::PooledTriangles out;
    export_to(out);
    return out;
}

template <class Exported>
void TriangleForest::export_to(Exported& out) const {
    std::vector<LeafRun> runs = leaf_runs();
    const auto run_count = static_cast<std::uint32_t>(runs.size());
    std::size_t total = 0;
    for (LeafRun& run : runs) {
        run.first_triangle = total;
        total += run.triangles;
    }
    detail::resize_large(out.triangles, total);
    detail::resize_large(out.faces, total);
    detail::resize_large(out.leaves, total);
    for_each_index(
        run_count, [&](std::uint32_t i) { write_run(runs[i], out); }, 1);
    runs.clear();
    detail::number_points(out, sites_.size(), point_count_);
    detail::resize_large(out.sites, out.points.size());
    for_each_index(static_cast<std::uint32_t>(out.points.size()),
                   [&](std::uint32_t i) { out.sites[i] = sites_[out.points[i].value]; });
}

}  // namespace tetrakis
