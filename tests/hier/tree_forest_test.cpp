#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../hier/trees/triangle_cell.hpp"
#include "../../hier/trees/triangle_forest.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../../refine/points/vertex_links.hpp"
#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

// What tests/contract/hierarchy_test.cpp does not see of the forests with children of one level.

using namespace tetrakis;

namespace {

/// random_mesh() with triangles only, and up to a third of its faces taken out (where the rest stays a manifold).
ControlMesh random_triangle_mesh(std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.triangles_only = true;
    if (seed % 3 != 0) options.removed_faces = static_cast<int>(test::Random(seed).below(20));
    return test::random_mesh(seed, options);
}

const SchemeInfo& doo_sabin() { return *find_scheme("doo-sabin"); }

void coarsen(auto& forest, std::span<const LeafId> marked, ForestChange& change) {
    if constexpr (std::is_same_v<std::remove_reference_t<decltype(forest)>, Sqrt3Forest>) {
        Sqrt3Forest::Changed removed;
        forest.coarsen(marked, change, removed);
    } else {
        forest.coarsen(marked, change);
    }
}

void check_refusals(auto&& forest) {
    ForestChange change, ignored;
    const std::vector<LeafId> roots = forest.ordered_leaves();
    forest.refine({&roots[1], 1}, change);
    const std::vector<LeafId> children = change.created, before = forest.ordered_leaves();
    for (const LeafId none : {roots[1], LeafId(1'000'000), LeafId{}}) {
        const std::array marked{children[0], none};
        CHECK_THROWS_AS(forest.refine(marked, ignored), Error);
        CHECK_THROWS_AS(coarsen(forest, marked, ignored), Error);
    }
    CHECK(forest.ordered_leaves() == before);
    CHECK(!check_forest(forest));
    // Spare room that is given back does not matter, and slots that are free again are no leaves.
    forest.shrink();
    coarsen(forest, children, change);
    CHECK(forest.ordered_leaves() == roots);
    const LeafId last = *std::ranges::max_element(children);
    CHECK_THROWS_AS(forest.refine({&last, 1}, ignored), Error);
    CHECK_THROWS_AS(coarsen(forest, {&last, 1}, ignored), Error);
    CHECK(!check_forest(forest));
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("forests take less than 64 bytes a leaf") {
    const auto bytes_a_leaf = [](auto&& forest) {
        ForestChange change;
        while (forest.leaf_count() < 20'000) forest.refine(forest.ordered_leaves(), change);
        return forest.memory_bytes() / double(forest.leaf_count());
    };
    const ControlMesh cube = test::model("cube"), triangles = triangulate(cube);
    CHECK(bytes_a_leaf(Sqrt3Forest(triangles)) < 64);
    CHECK(bytes_a_leaf(VertexForest(vertex_roots(cube, doo_sabin(), {}))) < 64);
}

TEST_CASE("[bad-input] forests refuse stale handles and meshes that they have no roots for, and stay as they are") {
    const ControlMesh cube = test::model("cube"), triangles = triangulate(cube);
    check_refusals(TriangleForest(triangles));
    check_refusals(Sqrt3Forest(triangles));
    check_refusals(VertexForest(vertex_roots(cube, doo_sabin(), {})));
    CHECK_THROWS_WITH_AS(TriangleForest{cube}, doctest::Contains("face 1 (line 12) has 4 corners"), Error);
    CHECK_THROWS_AS(vertex_roots(cube, *find_scheme("catmull-clark"), {}), Error);
}

TEST_CASE("sites of a triangle mesh are the same from tables and without") {
    for (const std::uint64_t seed : test::seeds(24)) {
        CAPTURE(seed);
        const ControlMesh mesh = random_triangle_mesh(seed);
        const TriangleSites sites(mesh);
        for (const std::uint8_t level : {0, 1, 2, 3})
            for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
                for (std::uint32_t x = 0; x <= 1u << level; ++x)
                    for (std::uint32_t y = 0; x + y <= 1u << level; ++y) {
                        const Site site{mesh.face_halfedge(FaceId(f)), {x, y}, level};
                        REQUIRE(canonical_triangle_site(mesh, site) == sites.canonical(site));
                    }
    }
}

TEST_CASE("merging one by one makes room in steps that grow: few of many merges take memory") {
    const ControlMesh mesh = random_triangle_mesh(1);
    TriangleForest forest(mesh);
    ForestChange change;
    while (forest.leaf_count() < 20000) forest.refine(forest.ordered_leaves(), change);
    int merges = 0, grown = 0;
    for (const LeafId leaf : forest.ordered_leaves()) {
        if (!forest.is_leaf(leaf) || forest.mergeable_siblings(leaf).empty()) continue;
        const std::uint64_t before = forest.memory_bytes();
        forest.coarsen(forest.mergeable_siblings(leaf), change);
        REQUIRE(change.created.size() == 1);
        ++merges;
        grown += forest.memory_bytes() != before ? 1 : 0;
    }
    CHECK(merges >= 4000);
    CHECK(grown < 100);
}

TEST_SUITE_END();
