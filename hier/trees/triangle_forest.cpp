#include "triangle_forest.hpp"

#include "../base/memory.hpp"
#include "../mesh/mesh_check.hpp"
#include "tree_forest_change.hpp"

#include <string>

namespace tetrakis {

template class TreeForest<RedTriangles>;

RedTriangles::RedTriangles(const ControlMesh& control) : mesh(&control) {
    for (std::uint32_t f = 0; f < mesh->face_count(); ++f)
        if (mesh->face_size(FaceId(f)) != 3)
            throw Error(ErrorCode::unsupported, detail::face_name(mesh->data(), f) + " has " +
                                                    std::to_string(mesh->face_size(FaceId(f))) +
                                                    " corners, but a triangle forest needs triangles; triangulate it");
}

Site RedTriangles::midpoint_site(const TreeFrame& frame, int edge) const {
    const std::uint32_t step = frame.flags != 0 ? ~std::uint32_t{0} : 1;
    LatticePoint at{2 * frame.at.x, 2 * frame.at.y};
    if (edge != 2) at.x += step;
    if (edge != 0) at.y += step;
    return canonical_triangle_site(*mesh, {HalfedgeId(3 * frame.root), at, static_cast<std::uint8_t>(frame.level + 1)});
}

TriangleForest::TriangleForest(const ControlMesh& mesh) : TreeForest(RedTriangles(mesh)) {
    sites_.resize(mesh.vertex_count());
    for (std::uint32_t h = 0; h < 3 * root_count_; ++h) {
        Site& site = sites_[mesh.origin(HalfedgeId(h)).value];
        if (!rule_.has_root(h / 3) || site.root.valid()) continue;
        ++point_count_;
        site = triangle_vertex_site(mesh, mesh.origin(HalfedgeId(h)));
    }
}

CellTriangle TriangleForest::triangle(const TreeFrame& f) {
    const std::uint32_t step = f.flags != 0 ? ~std::uint32_t{0} : 1;
    return {HalfedgeId(3 * f.root), f.level, {f.at, {f.at.x + step, f.at.y}, {f.at.x, f.at.y + step}}};
}

std::array<PointId, 3> TriangleForest::points(LeafId leaf) const {
    const auto p = corners(leaf.value);
    return {PointId(p[0]), PointId(p[1]), PointId(p[2])};
}

std::array<PointId, 3> TriangleForest::hanging_points(LeafId leaf) const {
    return {PointId(hanging_point(leaf.value, 0)), PointId(hanging_point(leaf.value, 1)),
            PointId(hanging_point(leaf.value, 2))};
}

// Output.

namespace {

// Corners of a leaf's output triangles: 0, 1, 2 are the leaf's corners, 3 + e is the midpoint of edge e.
struct GreenPattern {
    std::uint8_t count = 1;
    std::uint8_t corner[4][3] = {{0, 1, 2}, {}, {}, {}};
};

// Patterns by the set of edges with a hanging midpoint. With two midpoints, the ear between them is cut off, and the
// remaining quadrilateral has its diagonal from the corner at the end of the whole edge. This depends only on the
// leaf's frame, so the pattern is the same whatever happened before. With three midpoints it is the leaf's children, in
// the order of child_corners().
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

// The set of edges with a hanging midpoint.
unsigned TriangleForest::hanging_mask(std::uint32_t slot) const {
    unsigned mask = 0;
    for (int e = 0; e < 3; ++e) {
        const std::uint32_t next = beyond(slot, e).slot;
        if (next < k_coarser && is_split(next)) mask |= 1u << e;
    }
    return mask;
}

GreenTriangles TriangleForest::green_triangles(LeafId leaf) const {
    const CellTriangle whole = triangle(leaf);
    const GreenPattern& pattern = k_patterns[hanging_mask(leaf.value)];
    GreenTriangles green{pattern.count, {whole}};
    if (green.count == 1) return green;
    std::array<LatticePoint, 6> at;
    for (std::size_t e = 0; e < 3; ++e) {
        const LatticePoint p = whole.corner[e], q = whole.corner[(e + 1) % 3];
        at[e] = {2 * p.x, 2 * p.y};
        at[3 + e] = {p.x + q.x, p.y + q.y};
    }
    for (int t = 0; t < green.count; ++t) {
        green.cell[t].root = whole.root;
        green.cell[t].level = static_cast<std::uint8_t>(whole.level + 1);
        for (int k = 0; k < 3; ++k) green.cell[t].corner[k] = at[pattern.corner[t][k]];
    }
    return green;
}

ExportedTriangles TriangleForest::exported() const {
    ExportedTriangles out;
    detail::reserve_large(out.triangles, leaf_count_);
    detail::reserve_large(out.faces, leaf_count_);
    detail::reserve_large(out.leaves, leaf_count_);
    for (const LeafId leaf : ordered_leaves()) {
        const std::uint32_t slot = leaf.value, mask = hanging_mask(slot);
        const auto own = corners(slot);
        std::array<std::uint32_t, 6> point{own[0], own[1], own[2], 0, 0, 0};
        for (int e = 0; e < 3; ++e)
            if (mask >> e & 1) point[3 + e] = hanging_point(slot, e);
        const GreenPattern& pattern = k_patterns[mask];
        for (int k = 0; k < pattern.count; ++k) {
            const auto& [a, b, c] = pattern.corner[k];
            out.triangles.push_back({point[a], point[b], point[c]});
            out.faces.emplace_back(root_of(slot));
            out.leaves.push_back(leaf);
        }
    }
    detail::number_points(out, *this, point_count_);
    return out;
}

}  // namespace tetrakis
