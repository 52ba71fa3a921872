#include "../../hier/forest/triangle_forest.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <numeric>
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

// The triangles that are split.
std::set<Cell> split_cells(const TriangleForest& forest) {
    std::set<Cell> cells;
    for (const LeafId leaf : leaves_of(forest)) {
        const CellTriangle t = forest.triangle(leaf);
        for (int level = 0; level < t.level; ++level) cells.insert(cell_at(t, level));
    }
    return cells;
}

LeafId random_leaf(const TriangleForest& forest, std::mt19937& random) {
    for (;;) {
        const LeafId leaf(static_cast<std::uint32_t>(random() % forest.leaf_slots()));
        if (forest.is_leaf(leaf)) return leaf;
    }
}

// Thousands of splits with a taste for a few places, and merges in between.
void random_history(TriangleForest& forest, std::mt19937& random, int steps, int max_level) {
    std::vector<LeafId> created, changed;
    for (int i = 0; i < steps; ++i) {
        const LeafId leaf = random_leaf(forest, random);
        if (random() % 3 == 0) {
            if (forest.can_merge(leaf)) forest.merge(leaf);
        } else if (random() % 8 == 0) {
            std::vector<LeafId> some = leaves_of(forest);
            std::erase_if(some, [&](LeafId) { return random() % 2 == 0; });
            forest.coarsen(some, created, changed);
        } else if (forest.level(leaf) < max_level) {
            forest.split(leaf);
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
    const auto fault = forest.check();
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

TEST_CASE("[inv3] [inv4] any history of a triangle forest leaves a conforming, restricted mesh") {
    for (const std::uint64_t seed : test::seeds(k_seeds)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        TriangleForest forest(mesh);
        std::mt19937 random(static_cast<std::uint32_t>(seed));
        if (forest.leaf_count() == 0) continue;
        require_conforming(forest);
        for (int i = 0; i < 8; ++i) {
            random_history(forest, random, 60, 9);
            require_whole(forest);
            require_conforming(forest);
        }
    }
}

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
    CHECK_THROWS_AS(empty.split(LeafId(0)), Error);

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

TEST_CASE("[inv2] [inv10] the export of a triangle forest knows its leaves, not how they came about") {
    for (const std::uint64_t seed : test::seeds(k_seeds)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        TriangleForest first(mesh);
        std::mt19937 random(static_cast<std::uint32_t>(seed));
        if (first.leaf_count() == 0) continue;
        random_history(first, random, 500, 8);
        const ExportedTriangles expected = first.exported();
        const std::set<Cell> wanted = split_cells(first);
        const auto is_wanted = [&](const TriangleForest& forest, LeafId leaf) {
            const CellTriangle t = forest.triangle(leaf);
            return wanted.count(cell_at(t, t.level)) != 0;
        };
        // In bulk, for several numbers of threads.
        for (const int threads : {1, 2, 4}) {
            RunContext context;
            context.threads = threads;
            TriangleForest second(mesh);
            with_threads(context, [&] {
                std::vector<LeafId> created, changed;
                for (;;) {
                    std::vector<LeafId> marked = leaves_of(second);
                    std::erase_if(marked, [&](LeafId leaf) { return !is_wanted(second, leaf); });
                    if (marked.empty()) break;
                    std::shuffle(marked.begin(), marked.end(), random);
                    second.refine(marked, created, changed);
                }
            });
            require_whole(second);
            REQUIRE(same_mesh(second.exported(), expected));
        }
        // One by one in random order, too far, and back again.
        TriangleForest third(mesh);
        for (bool is_done = false; !is_done;) {
            std::vector<LeafId> marked = leaves_of(third);
            std::shuffle(marked.begin(), marked.end(), random);
            is_done = true;
            for (const LeafId leaf : marked)
                if (third.is_leaf(leaf) && is_wanted(third, leaf)) {
                    third.split(leaf);
                    is_done = false;
                }
        }
        REQUIRE(same_mesh(third.exported(), expected));
        for (int i = 0; i < 100; ++i) third.split(random_leaf(third, random));
        std::vector<LeafId> created, changed;
        for (;;) {
            std::vector<LeafId> surplus = leaves_of(third);
            std::erase_if(surplus, [&](LeafId leaf) {
                const CellTriangle t = third.triangle(leaf);
                return t.level == 0 || wanted.count(cell_at(t, t.level - 1)) != 0;
            });
            if (surplus.empty()) break;
            third.coarsen(surplus, created, changed);
            REQUIRE(!created.empty());
        }
        require_whole(third);
        REQUIRE(same_mesh(third.exported(), expected));
        REQUIRE(third.point_count() == first.point_count());
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
            std::vector<LeafId> created, changed;
            forest.refine(marked, created, changed);
            require_whole(forest);
            std::set<LeafId> expected_created, expected_changed;
            for (const LeafId leaf : leaves_of(forest)) {
                const auto before = hanging_before.find(leaf.value);
                if (before == hanging_before.end())
                    expected_created.insert(leaf);
                else if (before->second != forest.hanging_points(leaf))
                    expected_changed.insert(leaf);
            }
            CHECK(std::set<LeafId>(created.begin(), created.end()) == expected_created);
            CHECK(created.size() == expected_created.size());
            CHECK(std::set<LeafId>(changed.begin(), changed.end()) == expected_changed);
            CHECK(changed.size() == expected_changed.size());

            std::vector<LeafId> by_closure = created;
            std::erase_if(by_closure, [&](LeafId leaf) {
                const CellTriangle t = forest.triangle(leaf);
                return asked_for.count(cell_at(t, t.level - 1)) != 0;
            });
            for (const LeafId leaf : leaves_of(forest)) hanging_before[leaf.value] = forest.hanging_points(leaf);
            forest.coarsen(by_closure, created, changed);
            CHECK(created.empty());
            CHECK(changed.empty());

            // Merging reports its changes too.
            std::vector<LeafId> some = leaves_of(forest);
            std::erase_if(some, [&](LeafId leaf) { return forest.level(leaf) < 3 || random() % 16 == 0; });
            const std::vector<LeafId> before_merge = leaves_of(forest);
            forest.coarsen(some, created, changed);
            require_whole(forest);
            const std::set<LeafId> parents(created.begin(), created.end());
            std::set<LeafId> now_changed;
            for (const LeafId leaf : before_merge)
                if (forest.is_leaf(leaf) && hanging_before[leaf.value] != forest.hanging_points(leaf))
                    now_changed.insert(leaf);
            CHECK(std::set<LeafId>(changed.begin(), changed.end()) == now_changed);
            for (const LeafId leaf : parents) CHECK(forest.is_leaf(leaf));
        }
    }
}

TEST_CASE("[inv5] merging undoes a split of a triangle forest; coarsening to the roots gives the roots") {
    for (const std::uint64_t seed : test::seeds(k_seeds)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        TriangleForest forest(mesh);
        std::mt19937 random(static_cast<std::uint32_t>(seed));
        if (forest.leaf_count() == 0) continue;
        const ExportedTriangles roots = forest.exported();
        const std::uint32_t root_points = forest.point_count();
        random_history(forest, random, 300, 8);
        std::vector<LeafId> created, changed;
        for (int i = 0; i < 100; ++i) {
            const LeafId leaf = random_leaf(forest, random);
            const ExportedTriangles before = forest.exported();
            const std::uint32_t points = forest.point_count();
            forest.refine({&leaf, 1}, created, changed);
            // What the closure split is merged one by one, too, the finest first.
            std::stable_sort(created.begin(), created.end(),
                             [&](LeafId a, LeafId b) { return forest.level(a) > forest.level(b); });
            bool is_back = false;
            for (std::size_t group = 0; group < created.size(); group += 4) {
                REQUIRE(forest.can_merge(created[group + 2]));
                is_back |= forest.merge(created[group + 2]) == leaf;
            }
            REQUIRE(is_back);
            require_whole(forest);
            REQUIRE(same_mesh(forest.exported(), before));
            REQUIRE(forest.point_count() == points);
        }
        for (int round = 0; round <= k_max_level; ++round) forest.coarsen(leaves_of(forest), created, changed);
        require_whole(forest);
        REQUIRE(same_mesh(forest.exported(), roots));
        REQUIRE(forest.point_count() == root_points);
    }
}

TEST_CASE("[inv5] any four siblings of an even triangle mesh merge alone, and are output as before") {
    for (const std::uint64_t seed : test::seeds(4)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_triangle_mesh(seed);
        TriangleForest forest(mesh);
        const ExportedTriangles roots = forest.exported();
        std::vector<LeafId> created, changed;
        for (int level = 0; level < 3; ++level) forest.refine(leaves_of(forest), created, changed);
        const ExportedTriangles even = forest.exported();
        for (const LeafId leaf : leaves_of(forest)) {
            REQUIRE(forest.can_merge(leaf));
            if (leaf != forest.siblings(leaf)[0]) continue;
            std::array<CellTriangle, 4> children;
            for (std::size_t k = 0; k < 4; ++k) children[k] = forest.triangle(forest.siblings(leaf)[k]);
            const LeafId parent = forest.merge(leaf);
            const auto hanging = forest.hanging_points(parent);
            if (hanging[0].valid() && hanging[1].valid() && hanging[2].valid()) {
                // What estimators see are the children's triangles.
                const GreenTriangles green = forest.green_triangles(parent);
                REQUIRE(green.count == 4);
                for (std::size_t k = 0; k < 4; ++k) {
                    REQUIRE(green.cell[k].root == children[k].root);
                    REQUIRE(green.cell[k].level == children[k].level);
                    REQUIRE(green.cell[k].corner == children[k].corner);
                }
                REQUIRE(same_mesh(forest.exported(), even));
            }
            forest.split(parent);
        }
        REQUIRE(same_mesh(forest.exported(), even));
        // One by one in any order, as far down as it goes: to the roots.
        std::mt19937 random(static_cast<std::uint32_t>(seed));
        for (bool is_done = false; !is_done;) {
            is_done = true;
            std::vector<LeafId> leaves = leaves_of(forest);
            std::shuffle(leaves.begin(), leaves.end(), random);
            for (const LeafId leaf : leaves)
                if (forest.is_leaf(leaf) && forest.can_merge(leaf)) {
                    forest.merge(leaf);
                    is_done = false;
                }
            require_whole(forest);
            require_conforming(forest);
        }
        REQUIRE(same_mesh(forest.exported(), roots));
    }
}

TEST_CASE("merging one by one makes room in steps that grow: few of many merges take memory") {
    const ControlMesh mesh = test::random_triangle_mesh(1);
    TriangleForest forest(mesh);
    std::vector<LeafId> created, changed;
    while (forest.leaf_count() < 20000) forest.refine(leaves_of(forest), created, changed);
    int merges = 0, grown = 0;
    for (const LeafId leaf : leaves_of(forest)) {
        if (!forest.is_leaf(leaf) || !forest.can_merge(leaf)) continue;
        const std::uint64_t before = forest.memory_bytes();
        forest.coarsen(forest.siblings(leaf), created, changed);
        REQUIRE(created.size() == 1);
        ++merges;
        grown += forest.memory_bytes() != before ? 1 : 0;
    }
    CHECK(merges >= 4000);
    CHECK(grown < 100);
}

TEST_CASE("[slow] [inv10] a large parallel refinement of a triangle forest gives the serial one's slots and points") {
    const ControlMesh mesh = test::random_triangle_mesh(6);
    const auto grow = [&](int threads) {
        RunContext context;
        context.threads = threads;
        TriangleForest forest(mesh);
        std::vector<LeafId> created, changed, log;
        with_threads(context, [&] {
            std::mt19937 random(1);
            std::vector<LeafId> marked = leaves_of(forest);
            for (int round = 0; round < 9; ++round) {
                forest.refine(marked, created, changed);
                log.insert(log.end(), created.begin(), created.end());
                log.insert(log.end(), changed.begin(), changed.end());
                marked = created;
                if (round > 3) std::erase_if(marked, [&](LeafId) { return random() % 5 >= 2; });
            }
        });
        require_whole(forest);
        return std::pair(std::move(log), forest.exported());
    };
    const auto [serial_log, serial_mesh] = grow(1);
    CHECK(serial_mesh.triangles.size() > 50000);
    for (const int threads : {2, 4}) {
        const auto [log, mesh_now] = grow(threads);
        CHECK(log == serial_log);
        CHECK(same_mesh(mesh_now, serial_mesh));
        CHECK(mesh_now.leaves == serial_mesh.leaves);
        CHECK(mesh_now.points == serial_mesh.points);
    }
}

TEST_CASE("a triangle forest refines to its deepest level and refuses to go beyond, unchanged") {
    const ControlMesh mesh = test::random_triangle_mesh(3);
    TriangleForest forest(mesh);
    LeafId leaf = leaves_of(forest).front();
    std::vector<LeafId> created, changed;
    std::mt19937 random(5);
    while (forest.level(leaf) < k_max_level) {
        const CellTriangle parent = forest.triangle(leaf);
        forest.refine({&leaf, 1}, created, changed);
        std::erase_if(created, [&](LeafId c) {
            const CellTriangle t = forest.triangle(c);
            return t.level != parent.level + 1 || cell_at(t, parent.level) != cell_at(parent, parent.level);
        });
        REQUIRE(created.size() == 4);
        leaf = created[random() % 4];
    }
    require_whole(forest);
    require_conforming(forest);
    const ExportedTriangles before = forest.exported();
    bool is_refused = false;
    try {
        forest.split(leaf);
    } catch (const Error& e) {
        is_refused = e.code() == ErrorCode::unsupported;
        CHECK(std::string(e.what()).find("level 30") != std::string::npos);
    }
    CHECK(is_refused);
    require_whole(forest);
    CHECK(same_mesh(forest.exported(), before));
}

TEST_CASE("[bad-input] a triangle forest refuses stale handles and polygons") {
    const ControlMesh mesh = test::random_triangle_mesh(0);
    TriangleForest forest(mesh);
    const LeafId leaf = leaves_of(forest).front();
    CHECK_FALSE(forest.can_merge(leaf));
    CHECK_THROWS_AS(forest.merge(leaf), Error);
    forest.split(leaf);
    const ExportedTriangles before = forest.exported();
    std::vector<LeafId> created, changed;
    const std::array<LeafId, 2> marked = {leaves_of(forest).back(), leaf};
    CHECK_THROWS_WITH_AS(forest.refine(marked, created, changed), doctest::Contains("is not a leaf"), Error);
    CHECK_THROWS_AS(forest.coarsen(marked, created, changed), Error);
    CHECK_THROWS_AS(forest.split(LeafId{}), Error);
    CHECK_THROWS_AS(forest.merge(leaf), Error);
    require_whole(forest);
    CHECK(same_mesh(forest.exported(), before));

    ControlMeshData quad;
    quad.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    quad.face_offsets = {0, 4};
    quad.face_vertices = {0, 1, 2, 3};
    const ControlMesh square = ControlMesh::build(quad);
    CHECK_THROWS_WITH_AS(TriangleForest{square}, doctest::Contains("face 0 has 4 corners"), Error);
}

TEST_SUITE_END();
