#include "../../hier/base/error.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../hier/trees/triangle_forest.hpp"
#include "../../hier/trees/vertex_forest.hpp"
#include "../../refine/points/vertex_links.hpp"
#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <cstdint>

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

TEST_CASE("[bad-input] forests refuse meshes that they have no roots for") {
    const ControlMesh cube = test::model("cube");
    CHECK_THROWS_WITH_AS(TriangleForest{cube}, doctest::Contains("face 1 (line 12) has 4 corners"), Error);
    CHECK_THROWS_AS(vertex_roots(cube, *find_scheme("catmull-clark"), {}), Error);
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
