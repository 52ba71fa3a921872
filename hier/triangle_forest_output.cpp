#include "tetrakis/hier/parallel.hpp"
#include "tetrakis/hier/triangle_forest.hpp"

#include <limits>

namespace tetrakis {

namespace {

// Corners of a leaf's output triangles: 0, 1, 2 are its own, 3 + e is the midpoint of edge e.
struct GreenPattern {
    std::uint8_t count = 1;
    std::uint8_t corner[3][3] = {{0, 1, 2}, {}, {}};
};

// By the set of edges with a hanging midpoint. With two of them the ear between is cut off, and the quadrilateral that
// is left has its diagonal from the corner at the end of the whole edge: a rule that knows only the leaf's own frame,
// so that the pattern is the same whatever happened before.
constexpr std::array<GreenPattern, 7> make_patterns() {
    std::array<GreenPattern, 7> pattern{};
    for (unsigned e = 0; e < 3; ++e) {
        const auto a = static_cast<std::uint8_t>(e), b = static_cast<std::uint8_t>((e + 1) % 3),
                   c = static_cast<std::uint8_t>((e + 2) % 3);
        const auto m = static_cast<std::uint8_t>(3 + a), n = static_cast<std::uint8_t>(3 + b);
        pattern[1u << a] = {2, {{a, m, c}, {m, b, c}, {}}};
        pattern[1u << a | 1u << b] = {3, {{m, b, n}, {a, m, n}, {a, n, c}}};
    }
    return pattern;
}

constexpr std::array<GreenPattern, 7> k_patterns = make_patterns();

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

// Depth first, children by their numbers: the order of (root, path).
std::vector<std::uint32_t> TriangleForest::leaves_in_order() const {
    std::vector<std::uint32_t> leaves, open;
    leaves.reserve(leaf_count_);
    for (std::uint32_t f = 0; f < root_count_; ++f) {
        if (child_[f] == k_dead) continue;
        open.push_back(f);
        while (!open.empty()) {
            const std::uint32_t slot = open.back();
            open.pop_back();
            if (!is_split(slot)) {
                leaves.push_back(slot);
                continue;
            }
            for (std::uint32_t k = 4; k-- > 0;) open.push_back(first_child(child_[slot]) + k);
        }
    }
    return leaves;
}

ExportedTriangles TriangleForest::exported() const {
    ExportedTriangles out;
    const std::vector<std::uint32_t> leaves = leaves_in_order();
    std::vector<std::uint32_t> first(leaves.size());
    for_each_index(static_cast<std::uint32_t>(leaves.size()),
                   [&](std::uint32_t i) { first[i] = k_patterns[hanging_mask(leaves[i])].count; });
    std::size_t total = 0;
    for (std::uint32_t& n : first) {
        const std::uint32_t count = n;
        n = static_cast<std::uint32_t>(total);
        total += count;
    }
    out.triangles.resize(total);
    out.faces.resize(total);
    out.leaves.resize(total);
    for_each_index(static_cast<std::uint32_t>(leaves.size()), [&](std::uint32_t i) {
        const std::uint32_t slot = leaves[i], mask = hanging_mask(slot);
        const auto own = corners(slot);
        std::array<std::uint32_t, 6> point{own[0], own[1], own[2], 0, 0, 0};
        for (std::uint32_t e = 0; e < 3; ++e)
            if (mask >> e & 1) point[3 + e] = hanging_point(slot, e);
        const GreenPattern& pattern = k_patterns[mask];
        for (std::uint32_t t = 0; t < pattern.count; ++t) {
            const std::uint32_t place = first[i] + t;
            for (int k = 0; k < 3; ++k) out.triangles[place][k] = point[pattern.corner[t][k]];
            out.faces[place] = face(LeafId(slot));
            out.leaves[place] = LeafId(slot);
        }
    });
    std::vector<std::uint32_t> number(sites_.size(), PointId::none);
    out.points.reserve(point_count_);
    for (auto& triangle : out.triangles)
        for (std::uint32_t& p : triangle) {
            if (number[p] == PointId::none) {
                number[p] = static_cast<std::uint32_t>(out.points.size());
                out.points.push_back(PointId(p));
            }
            p = number[p];
        }
    out.sites.resize(out.points.size());
    for_each_index(static_cast<std::uint32_t>(out.points.size()),
                   [&](std::uint32_t i) { out.sites[i] = sites_[out.points[i].value]; });
    return out;
}

}  // namespace tetrakis
