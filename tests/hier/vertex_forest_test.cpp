#include "../kit/adaptive_dual.hpp"
#include "../kit/dual_mesh.hpp"
#include "../kit/point_match.hpp"
#include "../kit/refine_by_rules.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <string>
#include <tuple>
#include <vector>

using namespace tetrakis;
using test::model;

namespace {

std::vector<std::vector<std::uint32_t>> cycles(const std::vector<std::uint32_t>& offsets,
                                               const std::vector<std::uint32_t>& vertices) {
    std::vector<std::vector<std::uint32_t>> result;
    for (std::size_t f = 0; f + 1 < offsets.size(); ++f)
        result.emplace_back(vertices.begin() + offsets[f], vertices.begin() + offsets[f + 1]);
    return result;
}

void refine_randomly(VertexForest& forest, test::Random& random, int calls, double chance, int deepest) {
    ForestChange change;
    for (int i = 0; i < calls; ++i) {
        std::vector<LeafId> marked;
        for (const LeafId leaf : forest.ordered_leaves())
            if (random.chance(chance) && forest.level(leaf) < deepest) marked.push_back(leaf);
        random.shuffle(marked);
        forest.refine(marked, change);
    }
}

/// The mesh with its points, which differ by rounding errors, moved to the nearest ones of another.
PolygonMesh moved_to(PolygonMesh mesh, const std::vector<Vec3d>& points) {
    const PointMatch match(points);
    for (Vec3d& p : mesh.positions)
        if (const Vec3d& nearest = points[match.nearest(p)]; glm::length(nearest - p) < 1e-12) p = nearest;
    return mesh;
}

/// Which leaves, whatever their slots.
std::vector<VertexCell> leaf_cells(const VertexForest& forest) {
    std::vector<VertexCell> cells;
    for (const LeafId leaf : forest.ordered_leaves()) cells.push_back(forest.cell(leaf));
    return cells;
}

LeafId first_deepest(const VertexForest& forest, const std::vector<LeafId>& leaves) {
    return *std::ranges::max_element(leaves, {}, [&](LeafId leaf) { return forest.level(leaf); });
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv3] [inv4] vertex quadtrees: the dual mesh is conforming and keeps the topology of the control mesh") {
    int refined = 0, on_creases = 0;
    for (const std::uint64_t seed : test::seeds(48)) {
        CAPTURE(seed);
        const bool creased = seed % 2 == 1;
        const ControlMesh mesh = seed % 4 == 3 ? test::random_semi_sharp_dual_mesh(seed / 2)
                                 : creased     ? test::random_creased_dual_mesh(seed / 2)
                                               : test::random_dual_mesh(seed / 2);
        AdaptiveDual dual(mesh, *find_scheme(seed % 4 == 2 ? "biquartic" : "doo-sabin"));
        VertexForest& forest = dual.forest();
        test::Random random(seed);
        for (int round = 0; round < 4; ++round) {
            if (round > 0) refine_randomly(forest, random, 2, 0.15, 6);
            const auto fault = check_forest(forest);
            CHECK_MESSAGE(!fault.has_value(), fault.value_or(""));
            const DualFaces faces = forest.faces();
            const test::SurfaceTopology got = test::topology(cycles(faces.face_offsets, faces.face_vertices));
            const test::SurfaceTopology expected = test::surface_topology(mesh);
            CHECK(got.fault.empty());
            // Holes that touch creases may be joined where they touch each other.
            const bool holes = !mesh.data().holes.empty() || mesh.boundary_rule() == BoundaryRule::none;
            if (!creased || !holes) CHECK(got.euler == expected.euler);
            // Where parts of the surface touch in a vertex alone, the dual mesh joins them by that vertex's face.
            if (!holes) CHECK(got.boundary_loops == expected.boundary_loops);
            refined += static_cast<int>(forest.leaf_count());
            // Both sides of a crease have the same vertices, and each is one.
            on_creases += static_cast<int>(faces.other_sides.size());
            if (!holes) CHECK(faces.leaves.size() + faces.other_sides.size() == forest.leaf_count());
            for (const DualFaces::OtherSide& side : faces.other_sides)
                CHECK(forest.vertex_leaf(side.leaf) == faces.leaves[side.vertex]);
            for (const LeafId leaf : forest.ordered_leaves())
                for (int s = 0; s < 4; ++s) {
                    const LeafId other = forest.across_crease(leaf, s);
                    if (!other.valid()) continue;
                    CHECK(forest.is_leaf(other));
                    CHECK(forest.level(other) == forest.level(leaf));
                    CHECK(forest.vertex_leaf(other) == forest.vertex_leaf(leaf));
                    CHECK(!forest.neighbours(leaf, s)[0].valid());
                }
            // Restricted: by the neighbours as they are seen from either side.
            for (const LeafId leaf : forest.ordered_leaves())
                for (int s = 0; s < 4; ++s)
                    for (const LeafId next : forest.neighbours(leaf, s)) {
                        if (!next.valid()) continue;
                        CHECK(forest.is_leaf(next));
                        CHECK(std::abs(forest.level(next) - forest.level(leaf)) <= 1);
                        bool back = false;
                        for (int t = 0; t < 4; ++t)
                            for (const LeafId other : forest.neighbours(next, t)) back = back || other == leaf;
                        CHECK(back);
                    }
        }
    }
    CHECK(refined > 40000);
    CHECK(on_creases > 2000);
}

TEST_CASE("[inv1] vertex quadtrees: limits and normals on creases, where they cross and end, are those of a level") {
    for (const char* name : {"doo-sabin", "doo-sabin-cc", "midedge", "midedge-simplest"})
        for (const std::uint64_t seed : {6u, 8u, 9u, 14u}) {
            CAPTURE(name);
            CAPTURE(seed);
            test::RandomMeshOptions options = test::random_options(seed);
            options.hole = 0;
            options.crease = 0.25;
            options.boundary_rule = BoundaryRule::edge_and_corner;
            const bool semi_sharp = seed > 8;
            const ControlMesh mesh = test::random_dual_mesh(
                seed, options, semi_sharp ? test::DualTags::of_all_kinds : test::DualTags::infinitely_sharp);
            const int level = semi_sharp ? 3 : 2;
            AdaptiveDual dual(mesh, *find_scheme(name));
            ForestChange change;
            for (int l = 1; l < level; ++l) dual.forest().refine(dual.forest().ordered_leaves(), change);
            const PolygonMesh got = dual.to_mesh({.limit = true, .normals = true});
            const PolygonMesh at = refine_by_rules(mesh, *find_scheme(name), level);
            const PolygonMesh net = moved_to(dual.to_mesh({.limit = false}), at.positions);
            const RuleRefiner refiner(mesh, *find_scheme(name), level, {.limit = true, .normals = true});
            std::vector<Vec3d> limits(refiner.vertex_count()), normals(refiner.vertex_count());
            refiner.refine(mesh.positions(), limits);
            refiner.normals(mesh.positions(), normals);
            // By their points in the net, which few share.
            std::multimap<std::tuple<double, double, double>, std::uint32_t> vertices;
            for (std::uint32_t v = 0; v < at.positions.size(); ++v)
                vertices.insert({{at.positions[v].x, at.positions[v].y, at.positions[v].z}, v});
            REQUIRE(vertices.size() == net.positions.size());
            const double diagonal = mesh.bounding_box().diagonal();
            int off = 0, turned = 0;
            for (std::size_t v = 0; v < net.positions.size(); ++v) {
                const Vec3d& p = net.positions[v];
                bool there = false, same_normal = false;
                for (auto [at_point, end] = vertices.equal_range({p.x, p.y, p.z}); at_point != end; ++at_point) {
                    const std::uint32_t u = at_point->second;
                    if (!(glm::length(limits[u] - got.positions[v]) <= 1e-12 * diagonal)) continue;
                    there = true;
                    same_normal = same_normal || glm::length(normals[u] - got.normals[v]) <= 1e-9;
                }
                off += !there;
                turned += !same_normal;
            }
            CHECK(off == 0);
            // Creases that end leave triangles, where midedge-simplest has no tangent plane: both of its directions
            // shrink by 1/4, as what bends the surface does.
            if (!semi_sharp || name != std::string("midedge-simplest")) CHECK(turned == 0);
        }
}

TEST_CASE("vertex quadtrees take less than 64 bytes a leaf") {
    const ControlMesh mesh = model("cube");
    AdaptiveDual dual(mesh, *find_scheme("midedge"));
    VertexForest& forest = dual.forest();
    ForestChange change;
    for (int i = 0; i < 6; ++i) forest.refine(forest.ordered_leaves(), change);
    CHECK(forest.memory_bytes() < 64 * std::uint64_t{forest.leaf_count()});
}

TEST_CASE("[bad-input] vertex quadtrees refuse what is no leaf, too deep or of no quadtree, and stay as they are") {
    const ControlMesh mesh = model("cube");
    AdaptiveDual dual(mesh, *find_scheme("doo-sabin"));
    VertexForest& forest = dual.forest();
    ForestChange change;
    const LeafId root(3);
    forest.refine({&root, 1}, change);
    const std::vector<VertexCell> before = leaf_cells(forest);
    const std::vector<LeafId> mixed{LeafId(0), root}, outside{LeafId(5000)};
    CHECK_THROWS_AS(forest.refine(mixed, change), Error);
    CHECK_THROWS_AS(forest.refine(outside, change), Error);
    CHECK_THROWS_AS(forest.coarsen(mixed, change), Error);
    CHECK(leaf_cells(forest) == before);
    CHECK(forest.mergeable_siblings(LeafId(0)).empty());
    CHECK(forest.mergeable_siblings(root).empty());
    LeafId deep(0);
    for (int level = 0; level < k_max_level; ++level) {
        forest.refine({&deep, 1}, change);
        deep = first_deepest(forest, change.created);
    }
    CHECK_THROWS_AS(forest.refine({&deep, 1}, change), Error);
    CHECK(!check_forest(forest).has_value());

    CHECK_THROWS_AS(AdaptiveDual(mesh, *find_scheme("catmull-clark")), Error);
}

TEST_SUITE_END();
