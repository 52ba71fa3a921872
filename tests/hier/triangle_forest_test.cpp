#include "../../hier/trees/triangle_forest.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
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

struct Topology {
    std::int64_t euler = 0;
    std::uint32_t boundary_components = 0;
    friend bool operator==(const Topology&, const Topology&) = default;
};

// Counts edges; fails where an edge has more than two triangles or two of the same direction.
Topology topology(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    std::set<std::uint32_t> vertices;
    for (const auto& t : triangles)
        for (int k = 0; k < 3; ++k) {
            REQUIRE(t[k] != t[(k + 1) % 3]);
            REQUIRE(edges.emplace(t[k], t[(k + 1) % 3]).second);
            vertices.insert(t[k]);
        }
    std::map<std::uint32_t, std::uint32_t> root;
    const auto find = [&](std::uint32_t v) {
        while (root.at(v) != v) v = root.at(v) = root.at(root.at(v));
        return v;
    };
    std::int64_t boundary = 0;
    for (const auto& [a, b] : edges) {
        if (edges.count({b, a})) continue;
        ++boundary;
        root.emplace(a, a);
        root.emplace(b, b);
        root[find(a)] = find(b);
    }
    Topology result;
    for (const auto& [v, r] : root) result.boundary_components += v == r;
    const std::int64_t edge_count = (static_cast<std::int64_t>(edges.size()) + boundary) / 2;
    result.euler =
        static_cast<std::int64_t>(vertices.size()) - edge_count + static_cast<std::int64_t>(triangles.size());
    return result;
}

Topology control_topology(const ControlMesh& mesh) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        if (!mesh.is_hole(FaceId(f)))
            triangles.push_back({mesh.origin(HalfedgeId(3 * f)).value, mesh.origin(HalfedgeId(3 * f + 1)).value,
                                 mesh.origin(HalfedgeId(3 * f + 2)).value});
    return topology(triangles);
}

void require_whole(const TriangleForest& forest) {
    const auto fault = check_forest(forest);
    INFO(fault.value_or(""));
    REQUIRE(!fault);
}

// The exported mesh against what the leaves say about themselves: places by sites, topology, level differences.
void require_conforming(const TriangleForest& forest) {
    const ControlMesh& mesh = forest.mesh();
    const ExportedTriangles out = forest.exported();
    REQUIRE(topology(out.triangles) == control_topology(mesh));
    REQUIRE(std::set<Site>(out.sites.begin(), out.sites.end()).size() == out.sites.size());
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> level_at_edge;
    std::vector<std::uint64_t> area(mesh.face_count(), 0);  // in cells of level 31
    std::map<std::uint32_t, int> pieces;
    for (std::size_t i = 0; i < out.triangles.size(); ++i) {
        const LeafId leaf = out.leaves[i];
        REQUIRE(forest.is_leaf(leaf));
        REQUIRE(out.faces[i] == forest.face(leaf));
        const GreenTriangles green = forest.green_triangles(leaf);
        const int piece = pieces[leaf.value]++;
        REQUIRE(piece < green.count);
        const CellTriangle& cell = green.cell[piece];
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t p = out.triangles[i][k];
            REQUIRE(out.points[p] == green.point[piece][k]);
            REQUIRE(forest.point_site(out.points[p]) == out.sites[p]);
            REQUIRE(canonical_triangle_site(mesh, {cell.root, cell.corner[k], cell.level}) == out.sites[p]);
            level_at_edge[{p, out.triangles[i][(k + 1) % 3]}] = forest.level(leaf);
        }
        const auto& c = cell.corner;
        const std::int64_t ux = std::int64_t{c[1].x} - c[0].x, uy = std::int64_t{c[1].y} - c[0].y;
        const std::int64_t vx = std::int64_t{c[2].x} - c[0].x, vy = std::int64_t{c[2].y} - c[0].y;
        REQUIRE(ux * vy - uy * vx > 0);  // counter-clockwise
        area[out.faces[i].value] += static_cast<std::uint64_t>(ux * vy - uy * vx) << 2 * (k_max_level + 1 - cell.level);
    }
    for (const auto& [leaf, count] : pieces) REQUIRE(count == forest.green_triangles(LeafId(leaf)).count);
    REQUIRE(pieces.size() == forest.leaf_count());
    for (const auto& [edge, level] : level_at_edge)
        if (const auto other = level_at_edge.find({edge.second, edge.first}); other != level_at_edge.end())
            REQUIRE(std::abs(level - other->second) <= 1);
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        REQUIRE(area[f] == (mesh.is_hole(FaceId(f)) ? 0 : std::uint64_t{1} << 2 * (k_max_level + 1)));
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("[inv3] one triangle, a mesh of holes, and two triangles glued along all edges refine as well") {
    ControlMeshData single;
    single.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    single.face_offsets = {0, 3};
    single.face_vertices = {0, 1, 2};
    ControlMeshData holes = single;
    holes.holes = {0};
    const ControlMesh triangle = ControlMesh::build(single), hole = ControlMesh::build(holes);
    TriangleForest forest(triangle), empty(hole);
    std::mt19937 random(7);
    for (int i = 0; i < 20; ++i) {
        random_history(forest, random, 40, 8);
        require_whole(forest);
        require_conforming(forest);
    }
    require_whole(empty);
    CHECK(empty.leaf_count() == 0);
    CHECK(empty.exported().triangles.empty());
    ForestChange change;
    const LeafId none(0);
    CHECK_THROWS_AS(empty.refine({&none, 1}, change), Error);

    // Around a vertex of valence 2 both triangles have their third edge between the same points, at every level: an
    // edge count by points cannot tell those edges apart, so this mesh is left to check() and to the Euler
    // characteristic.
    ControlMeshData glued = single;
    glued.face_offsets = {0, 3, 6};
    glued.face_vertices = {0, 1, 2, 2, 1, 0};
    const ControlMesh pillow = ControlMesh::build(glued);
    TriangleForest both(pillow);
    for (int i = 0; i < 20; ++i) {
        random_history(both, random, 40, 8);
        require_whole(both);
        const ExportedTriangles out = both.exported();
        CHECK(out.triangles.size() + 4 == 2 * out.points.size());  // a closed surface with V - E + F = 2
    }
}

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
