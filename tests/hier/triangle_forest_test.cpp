#include "../../hier/trees/triangle_forest.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../../hier/trees/triangle_cell.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <vector>

using namespace tetrakis;

namespace {

bool same_mesh(const ExportedTriangles& a, const ExportedTriangles& b) {
    return a.triangles == b.triangles && a.faces == b.faces && a.sites == b.sites;
}

std::vector<LeafId> leaves_of(const TriangleForest& forest) {
    std::vector<LeafId> leaves;
    for (std::uint32_t i = 0; i < forest.leaf_slots(); ++i)
        if (forest.is_leaf(LeafId(i))) leaves.push_back(LeafId(i));
    return leaves;
}

void require_whole(const TriangleForest& forest) {
    const auto fault = check_forest(forest);
    INFO(fault.value_or(""));
    REQUIRE(!fault);
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("sites of a triangle mesh are the same from tables and without") {
    for (const std::uint64_t seed : test::seeds(24)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
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

TEST_CASE("[bad-input] a triangle forest refuses stale handles and polygons") {
    const ControlMesh mesh = test::random_triangle_mesh(0);
    TriangleForest forest(mesh);
    const LeafId leaf = leaves_of(forest).front();
    CHECK(forest.mergeable_siblings(leaf).empty());
    ForestChange change;
    forest.refine({&leaf, 1}, change);
    const ExportedTriangles before = forest.exported();
    const std::array<LeafId, 2> marked = {leaves_of(forest).back(), leaf};
    CHECK_THROWS_WITH_AS(forest.refine(marked, change), doctest::Contains("is not a leaf"), Error);
    CHECK_THROWS_AS(forest.coarsen(marked, change), Error);
    const LeafId invalid;
    CHECK_THROWS_AS(forest.refine({&invalid, 1}, change), Error);
    CHECK(forest.mergeable_siblings(leaf).empty());
    require_whole(forest);
    CHECK(same_mesh(forest.exported(), before));

    const ControlMesh square =
        ControlMesh::build(test::mesh_data({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}}));
    CHECK_THROWS_WITH_AS(TriangleForest{square}, doctest::Contains("face 0 has 4 corners"), Error);
}

TEST_CASE("merging one by one makes room in steps that grow: few of many merges take memory") {
    const ControlMesh mesh = test::random_triangle_mesh(1);
    TriangleForest forest(mesh);
    ForestChange change;
    while (forest.leaf_count() < 20000) forest.refine(leaves_of(forest), change);
    int merges = 0, grown = 0;
    for (const LeafId leaf : leaves_of(forest)) {
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
