#include "../../hier/trees/triangle_forest.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>

using namespace tetrakis;

namespace {

constexpr std::uint64_t k_seeds = 16;

bool same_mesh(const ExportedTriangles& a, const ExportedTriangles& b) {
    return a.triangles == b.triangles && a.faces == b.faces && a.sites == b.sites;
}

std::vector<LeafId> leaves_of(const TriangleForest& forest) {
    std::vector<LeafId> leaves;
    for (std::uint32_t i = 0; i < forest.leaf_slots(); ++i)
        if (forest.is_leaf(LeafId(i))) leaves.push_back(LeafId(i));
    return leaves;
}

// A triangle of the quadtrees, found from the geometry alone: the cell of a level that holds a leaf's centroid.
using Cell = std::tuple<std::uint32_t, int, std::uint64_t, std::uint64_t, bool>;
Cell cell_at(const CellTriangle& t, int level) {
    std::uint64_t x = 0, y = 0;
    for (const LatticePoint& p : t.corner) {
        x += p.x;
        y += p.y;
    }
    const std::uint64_t width = std::uint64_t{3} << (t.level - level);
    return {t.root.value, level, x / width, y / width, x % width + y % width < width};
}

LeafId random_leaf(const TriangleForest& forest, std::mt19937& random) {
    for (;;) {
        const LeafId leaf(static_cast<std::uint32_t>(random() % forest.leaf_slots()));
        if (forest.is_leaf(leaf)) return leaf;
    }
}

// Thousands of splits with a taste for a few places, and merges in between.
void random_history(TriangleForest& forest, std::mt19937& random, int steps, int max_level) {
    ForestChange change;
    for (int i = 0; i < steps; ++i) {
        const LeafId leaf = random_leaf(forest, random);
        if (random() % 3 == 0) {
            forest.coarsen(forest.mergeable_siblings(leaf), change);
        } else if (random() % 8 == 0) {
            std::vector<LeafId> some = leaves_of(forest);
            std::erase_if(some, [&](LeafId) { return random() % 2 == 0; });
            forest.coarsen(some, change);
        } else if (forest.level(leaf) < max_level) {
            forest.refine({&leaf, 1}, change);
        }
    }
}

void require_whole(const TriangleForest& forest) {
    const auto fault = check_forest(forest);
    INFO(fault.value_or(""));
    REQUIRE(!fault);
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("the closure of a triangle forest splits nothing that could be merged again, and reports what it changed") {
    for (const std::uint64_t seed : test::seeds(k_seeds)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        TriangleForest forest(mesh);
        std::mt19937 random(static_cast<std::uint32_t>(seed));
        if (forest.leaf_count() == 0) continue;
        random_history(forest, random, 200, 7);
        for (int i = 0; i < 10; ++i) {
            std::map<std::uint32_t, std::array<PointId, 3>> hanging_before;
            std::vector<LeafId> marked = leaves_of(forest);
            for (const LeafId leaf : marked) hanging_before[leaf.value] = forest.hanging_points(leaf);
            const std::uint32_t one_in = 2 + static_cast<std::uint32_t>(random() % 30);
            std::erase_if(marked, [&](LeafId) { return random() % one_in != 0; });
            std::set<Cell> asked_for;
            for (const LeafId leaf : marked) {
                const CellTriangle t = forest.triangle(leaf);
                asked_for.insert(cell_at(t, t.level));
            }
            ForestChange change;
            forest.refine(marked, change);
            require_whole(forest);
            std::set<LeafId> expected_created, expected_changed;
            for (const LeafId leaf : leaves_of(forest)) {
                const auto before = hanging_before.find(leaf.value);
                if (before == hanging_before.end())
                    expected_created.insert(leaf);
                else if (before->second != forest.hanging_points(leaf))
                    expected_changed.insert(leaf);
            }
            CHECK(std::set<LeafId>(change.created.begin(), change.created.end()) == expected_created);
            CHECK(change.created.size() == expected_created.size());
            CHECK(std::set<LeafId>(change.reshaped.begin(), change.reshaped.end()) == expected_changed);
            CHECK(change.reshaped.size() == expected_changed.size());

            std::vector<LeafId> by_closure = change.created;
            std::erase_if(by_closure, [&](LeafId leaf) {
                const CellTriangle t = forest.triangle(leaf);
                return asked_for.count(cell_at(t, t.level - 1)) != 0;
            });
            for (const LeafId leaf : leaves_of(forest)) hanging_before[leaf.value] = forest.hanging_points(leaf);
            forest.coarsen(by_closure, change);
            CHECK(change.created.empty());
            CHECK(change.reshaped.empty());

            // Merging reports its changes too.
            std::vector<LeafId> some = leaves_of(forest);
            std::erase_if(some, [&](LeafId leaf) { return forest.level(leaf) < 3 || random() % 16 == 0; });
            const std::vector<LeafId> before_merge = leaves_of(forest);
            forest.coarsen(some, change);
            require_whole(forest);
            const std::set<LeafId> parents(change.created.begin(), change.created.end());
            std::set<LeafId> now_changed;
            for (const LeafId leaf : before_merge)
                if (forest.is_leaf(leaf) && hanging_before[leaf.value] != forest.hanging_points(leaf))
                    now_changed.insert(leaf);
            CHECK(std::set<LeafId>(change.reshaped.begin(), change.reshaped.end()) == now_changed);
            for (const LeafId leaf : parents) CHECK(forest.is_leaf(leaf));
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

    ControlMeshData quad;
    quad.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    quad.face_offsets = {0, 4};
    quad.face_vertices = {0, 1, 2, 3};
    const ControlMesh square = ControlMesh::build(quad);
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
