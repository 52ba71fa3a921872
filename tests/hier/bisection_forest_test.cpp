#include "../../hier/forest/bisection_forest.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include <doctest/doctest.h>

#include <map>
#include <set>
#include <tuple>

using namespace tetrakis;
using test::Random;

namespace {

/// A node of the tree; ordered by root and path as exports are.
struct Node {
    std::uint32_t root;
    std::uint64_t aligned;
    int depth;
    friend auto operator<=>(const Node&, const Node&) = default;
};

Node node_of(const BisectionForest& forest, LeafId id) {
    const BisectionLeaf& l = forest.leaf(id);
    return {forest.root(id).value, l.depth == 0 ? 0 : l.path << (64 - l.depth), l.depth};
}

std::uint64_t path_of(const Node& n) { return n.depth == 0 ? 0 : n.aligned >> (64 - n.depth); }

/// The forest by brute force: a set of nodes, made conforming by looking for vertices in the middle of edges.
class NaiveForest {
  public:
    explicit NaiveForest(const ControlMesh& mesh) : mesh_(mesh) {
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
            if (!mesh.is_hole(mesh.face(HalfedgeId(h)))) leaves.insert({h, 0, 0});
    }

    void split(const Node& n) {
        leaves.erase(n);
        leaves.insert({n.root, n.aligned, n.depth + 1});
        leaves.insert({n.root, n.aligned | std::uint64_t{1} << (63 - n.depth), n.depth + 1});
    }
    /// Splits every leaf that has a vertex inside one of its edges until there is none.
    void close() {
        for (bool again = true; again;) {
            again = false;
            std::set<Site> vertices;
            for (const Node& n : leaves)
                for (const Site& s : corners(n)) vertices.insert(s);
            std::vector<Node> bad;
            for (const Node& n : leaves)
                for (const Site& s : middles(n))
                    if (vertices.count(s) != 0) {
                        bad.push_back(n);
                        break;
                    }
            for (const Node& n : bad) split(n);
            again = !bad.empty();
        }
    }
    std::vector<std::array<Site, 3>> triangles() const {
        std::vector<std::array<Site, 3>> result;
        for (const Node& n : leaves) result.push_back(corners(n));
        return result;
    }

    std::set<Node> leaves;

  private:
    Site site(HalfedgeId root, int level, std::int64_t x, std::int64_t y) const {
        const std::int64_t size = std::int64_t{1} << level;
        CellPoint p{root, x, y};
        if (p.x > size) p = cross(mesh_, p, CellSide::next_cell, size);
        return canonical(mesh_, {p.root,
                                 {static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y)},
                                 static_cast<std::uint8_t>(level)});
    }
    std::array<Site, 3> corners(const Node& n) const {
        const CellTriangle t = cell_triangle(mesh_, HalfedgeId(n.root), n.depth, path_of(n));
        std::array<Site, 3> result;
        for (std::size_t k = 0; k < 3; ++k) result[k] = site(t.root, t.level, t.corner[k].x, t.corner[k].y);
        return result;
    }
    std::array<Site, 3> middles(const Node& n) const {
        const CellTriangle t = cell_triangle(mesh_, HalfedgeId(n.root), n.depth, path_of(n));
        std::array<Site, 3> result;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto &p = t.corner[k], &q = t.corner[(k + 1) % 3];
            // Legs of the root triangle have their middle at (1/2, 1/2) of a corner cell: level 1, in its own frame.
            result[k] = site(t.root, t.level + 1, std::int64_t{p.x} + q.x, std::int64_t{p.y} + q.y);
        }
        return result;
    }
    const ControlMesh& mesh_;
};

std::vector<LeafId> leaves_of(const BisectionForest& forest) {
    std::vector<LeafId> result;
    for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s)
        if (forest.is_leaf(LeafId(s))) result.push_back(LeafId(s));
    return result;
}

std::vector<LeafId> random_subset(const std::vector<LeafId>& ids, double chance, Random& random) {
    std::vector<LeafId> result;
    for (LeafId id : ids)
        if (random.chance(chance)) result.push_back(id);
    return result;
}

/// Splits leaves of `forest` that are ancestors of a target node until its leaves are the target.
void refine_towards(BisectionForest& forest, const std::set<Node>& target, bool one_by_one, Random& random) {
    std::vector<LeafId> marked, created;
    for (int pass = 0; pass <= k_max_bisection_depth; ++pass) {
        marked.clear();
        for (LeafId id : leaves_of(forest))
            if (target.count(node_of(forest, id)) == 0) marked.push_back(id);
        if (marked.empty()) return;
        random.shuffle(marked);
        if (!one_by_one) {
            forest.refine(marked, created);
            continue;
        }
        std::vector<Node> nodes;
        for (LeafId id : marked) nodes.push_back(node_of(forest, id));
        for (std::size_t i = 0; i < marked.size(); ++i)  // a closure may have split it already
            if (forest.is_leaf(marked[i]) && node_of(forest, marked[i]) == nodes[i]) forest.split(marked[i]);
    }
}

void check_same_export(const ExportedTriangles& a, const ExportedTriangles& b) {
    CHECK(a.triangles == b.triangles);
    CHECK(a.faces == b.faces);
    CHECK(a.sites == b.sites);
}

void check_sound(const BisectionForest& forest) {
    const auto fault = forest.check();
    CHECK_MESSAGE(!fault, fault.value_or(""));
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("[inv2] bulk refinement is the smallest conforming refinement, as found by brute force") {
    for (std::uint64_t seed : test::seeds(12)) {
        CAPTURE(seed);
        test::RandomMeshOptions options = test::random_options(seed);
        options.columns = options.rows = 3;
        const ControlMesh mesh = test::random_mesh(seed, options);
        Random random(seed);
        BisectionForest forest(mesh);
        NaiveForest naive(mesh);
        std::vector<LeafId> created;
        for (int pass = 0; pass < 5; ++pass) {
            const std::vector<LeafId> before = leaves_of(forest);
            const auto marked = random_subset(before, 0.15, random);
            std::map<std::uint32_t, Node> old;
            for (LeafId id : before) old[id.value] = node_of(forest, id);
            for (LeafId id : marked) naive.split(node_of(forest, id));
            naive.close();
            forest.refine(marked, created);
            check_sound(forest);
            std::set<Node> leaves;
            for (LeafId id : leaves_of(forest)) leaves.insert(node_of(forest, id));
            REQUIRE(leaves == naive.leaves);
            // `created` are exactly the leaves that were none before.
            std::set<std::uint32_t> fresh;
            for (LeafId id : created) REQUIRE(fresh.insert(id.value).second);
            for (LeafId id : leaves_of(forest)) {
                const auto was = old.find(id.value);
                REQUIRE((was != old.end() && was->second == node_of(forest, id)) == (fresh.count(id.value) == 0));
            }
        }
        const ExportedTriangles out = forest.exported();
        const auto expected = naive.triangles();
        REQUIRE(out.triangles.size() == expected.size());
        for (std::size_t t = 0; t < expected.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) REQUIRE(out.sites[out.triangles[t][k]] == expected[t][k]);
    }
}

TEST_CASE("[inv2] [inv10] the same leaves export the same bytes, whatever the history and the number of threads") {
    for (std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        Random random(seed);
        BisectionForest forest(mesh);
        std::vector<LeafId> created;
        // Thousands of splits and merges, single and in bulk.
        for (int op = 0; op < 400; ++op) {
            const auto all = leaves_of(forest);
            if (all.empty()) break;
            if (op % 40 == 7)
                forest.refine(random_subset(all, 0.1, random), created);
            else if (op % 40 == 27)
                forest.coarsen(random_subset(all, 0.9, random), created);
            else
                for (int i = 0; i < 10; ++i) {
                    const LeafId id = all[random.below(static_cast<std::uint32_t>(all.size()))];
                    if (!forest.is_leaf(id) || forest.depth(id) > 14) continue;
                    if (random.chance(0.5))
                        forest.split(id);
                    else if (forest.can_merge(id))
                        forest.merge(id);
                }
            if (op % 40 == 0) check_sound(forest);
        }
        check_sound(forest);
        std::set<Node> target;
        for (LeafId id : leaves_of(forest)) target.insert(node_of(forest, id));
        const ExportedTriangles expected = forest.exported();
        REQUIRE(expected.triangles.size() == target.size());
        for (bool one_by_one : {true, false}) {
            BisectionForest other(mesh);
            refine_towards(other, target, one_by_one, random);
            check_sound(other);
            check_same_export(other.exported(), expected);
        }
    }
}

TEST_CASE("[inv10] slots, points and the list of new leaves are the same for 1, 2 and 4 threads") {
    test::RandomMeshOptions options;
    options.columns = options.rows = 7;
    const ControlMesh mesh = test::random_mesh(11, options);
    struct Result {
        std::vector<LeafId> created;
        std::vector<std::array<PointId, 3>> vertices;
        std::vector<std::array<LeafId, 3>> neighbours;
        std::vector<Site> sites;
        ExportedTriangles exported;
    };
    const auto run = [&](int threads) {
        RunContext context;
        context.threads = threads;
        return with_threads(context, [&] {
            Result r;
            Random random(4);
            BisectionForest forest(mesh);
            std::vector<LeafId> created;
            while (forest.leaf_count() < 60'000) {
                // In random order, so that threads meet in each other's closures.
                auto marked = random_subset(leaves_of(forest), 0.4, random);
                random.shuffle(marked);
                forest.refine(marked, created);
                r.created.insert(r.created.end(), created.begin(), created.end());
                forest.coarsen(random_subset(leaves_of(forest), 0.3, random), created);
                r.created.insert(r.created.end(), created.begin(), created.end());
            }
            check_sound(forest);
            for (std::uint32_t s = 0; s < forest.leaf_slots(); ++s)
                if (forest.is_leaf(LeafId(s))) {
                    r.vertices.push_back(forest.leaf(LeafId(s)).vertex);
                    r.neighbours.push_back(forest.leaf(LeafId(s)).neighbour);
                }
            for (std::uint32_t p = 0; p < forest.point_slots(); ++p) r.sites.push_back(forest.point_site(PointId(p)));
            r.exported = forest.exported();
            return r;
        });
    };
    const Result one = run(1);
    for (int threads : {2, 4}) {
        CAPTURE(threads);
        const Result other = run(threads);
        CHECK(other.created == one.created);
        CHECK(other.vertices == one.vertices);
        CHECK(other.neighbours == one.neighbours);
        CHECK(other.sites == one.sites);
        check_same_export(other.exported, one.exported);
        CHECK(other.exported.leaves == one.exported.leaves);
    }
}

TEST_CASE("[inv3] every edge is used once in each direction, and the topology is the control mesh's less its holes") {
    for (std::uint64_t seed : test::seeds(25)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        Random random(seed);
        BisectionForest forest(mesh);
        const auto expected = test::surface_topology(mesh);
        REQUIRE(expected.fault.empty());
        std::vector<LeafId> created;
        for (int pass = 0; pass < 6; ++pass) {
            forest.refine(random_subset(leaves_of(forest), 0.2, random), created);
            const auto found = test::topology(forest.exported().triangles);
            CHECK(found.fault.empty());
            CHECK(found.euler == expected.euler);
            CHECK(found.boundary_loops == expected.boundary_loops);
        }
    }
}

TEST_CASE("a leaf takes 48 bytes and a point 16 once working memory is given back") {
    const ControlMesh mesh = test::random_mesh(5);
    BisectionForest forest(mesh);
    std::vector<LeafId> created;
    while (forest.leaf_count() < 20'000) forest.refine(leaves_of(forest), created);
    const ExportedTriangles before = forest.exported();
    forest.shrink();
    // Slots of holes are never leaves.
    CHECK(forest.memory_bytes() <= 48 * std::uint64_t{forest.leaf_slots()} + 16 * std::uint64_t{forest.point_slots()});
    CHECK(forest.leaf_slots() <= forest.leaf_count() + mesh.halfedge_count());
    check_sound(forest);
    check_same_export(forest.exported(), before);
    forest.refine(leaves_of(forest), created);
    check_sound(forest);
}

TEST_CASE("[inv5] a merge undoes a split, and coarsening ends at the roots") {
    for (std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_mesh(seed);
        Random random(seed);
        BisectionForest forest(mesh);
        const ExportedTriangles roots = forest.exported();
        const std::uint32_t root_count = forest.leaf_count();
        std::vector<LeafId> created;
        for (int pass = 0; pass < 8; ++pass) forest.refine(random_subset(leaves_of(forest), 0.2, random), created);
        for (int trial = 0; trial < 60 && forest.leaf_count() > 0; ++trial) {
            const auto all = leaves_of(forest);
            const LeafId id = all[random.below(static_cast<std::uint32_t>(all.size()))];
            const Node node = node_of(forest, id);
            const ExportedTriangles before = forest.exported();
            const std::uint32_t count = forest.leaf_count();
            const bool alone = forest.split(id) <= 4 && forest.leaf_count() <= count + 2;
            if (!alone) continue;  // its closure split others: those would have to be merged first
            REQUIRE(forest.can_merge(id));
            const auto parents = forest.merge(id);
            CHECK((parents[0] == id || parents[1] == id));
            CHECK((parents[0].valid() && forest.is_leaf(parents[0])));
            // The other one is across the base; none at the boundary.
            const LeafId beside = parents[0] == id ? parents[1] : parents[0];
            CHECK(beside == forest.leaf(id).neighbour[0]);
            CHECK(node_of(forest, id) == node);
            CHECK(forest.leaf_count() == count);
            check_same_export(forest.exported(), before);
        }
        check_sound(forest);
        for (int pass = 0; pass < 200 && forest.leaf_count() > root_count; ++pass)
            forest.coarsen(random_subset(leaves_of(forest), 0.95, random), created);
        check_sound(forest);
        CHECK(forest.leaf_count() == root_count);
        CHECK(forest.midpoint_count() == 0);
        check_same_export(forest.exported(), roots);
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
            CHECK(forest.root_leaf(HalfedgeId(h)).valid() == !mesh.is_hole(mesh.face(HalfedgeId(h))));
    }
}

TEST_CASE("the depth limit is an error that changes nothing") {
    const ControlMesh mesh = test::random_mesh(2);
    BisectionForest forest(mesh);
    Random random(1);
    LeafId deepest = leaves_of(forest).front();
    std::vector<LeafId> created;
    while (forest.depth(deepest) < k_max_bisection_depth) {
        const std::array one{deepest};
        forest.refine(one, created);
        deepest = created.front();
        REQUIRE(created.size() < 10'000);
        for (LeafId id : created)
            if (forest.depth(id) > forest.depth(deepest) ||
                (forest.depth(id) == forest.depth(deepest) && random.chance(0.3)))
                deepest = id;
    }
    check_sound(forest);
    CHECK(forest.triangle(deepest).level == k_max_level);
    const ExportedTriangles before = forest.exported();
    const std::vector<LeafId> marked{leaves_of(forest).front(), deepest};
    try {
        forest.refine(marked, created);
        FAIL("no error");
    } catch (const Error& e) {
        CHECK(e.code() == ErrorCode::unsupported);
        CHECK(std::string(e.what()).find(std::to_string(deepest.value)) != std::string::npos);
    }
    check_sound(forest);
    check_same_export(forest.exported(), before);
}

TEST_CASE("[bad-input] stale and invalid handles are named, and nothing changes") {
    const ControlMesh mesh = test::random_mesh(4);
    BisectionForest forest(mesh);
    const auto roots = leaves_of(forest);
    std::vector<LeafId> created;
    forest.refine(roots, created);
    // A slot above the roots that its diamond's merge frees.
    LeafId stale;
    for (LeafId id : created)
        if (id.value >= mesh.halfedge_count() && forest.can_merge(id)) stale = id;
    REQUIRE(stale.valid());
    forest.merge(stale);
    REQUIRE(!forest.is_leaf(stale));
    const ExportedTriangles before = forest.exported();
    const auto fails = [&](auto&& call, LeafId id) {
        try {
            call();
            FAIL("no error");
        } catch (const Error& e) {
            CHECK(e.code() == ErrorCode::invalid_input);
            CHECK(std::string(e.what()).find(std::to_string(id.value)) != std::string::npos);
        }
        check_sound(forest);
        check_same_export(forest.exported(), before);
    };
    for (LeafId id : {stale, LeafId(forest.leaf_slots()), LeafId{}}) {
        CHECK(!forest.can_merge(id));
        const std::vector<LeafId> marked{roots.front(), id};
        fails([&] { forest.split(id); }, id);
        fails([&] { forest.refine(marked, created); }, id);
        fails([&] { forest.merge(id); }, id);
        fails([&] { forest.coarsen(marked, created); }, id);
    }
    LeafId root;
    for (LeafId id : leaves_of(forest))
        if (forest.depth(id) == 0) root = id;
    REQUIRE(root.valid());
    CHECK(!forest.can_merge(root));
    fails([&] { forest.merge(root); }, root);
}

TEST_CASE("repeated marks split a leaf once") {
    const ControlMesh mesh = test::random_mesh(6);
    BisectionForest once(mesh), often(mesh);
    std::vector<LeafId> marked = leaves_of(once), repeated = marked, created, created_often;
    marked.resize(marked.size() / 2);
    repeated = marked;
    repeated.insert(repeated.end(), marked.rbegin(), marked.rend());
    once.refine(marked, created);
    often.refine(repeated, created_often);
    CHECK(created == created_often);
    check_sound(often);
    marked = created;
    marked.insert(marked.end(), created.begin(), created.end());
    CHECK(once.coarsen(created, created) == often.coarsen(marked, created_often));
    CHECK(created == created_often);
    check_sound(once);
    check_sound(often);
}

TEST_CASE("[bad-input] [inv10] of thousands of marks the first bad one is named and repeated ones count once") {
    const ControlMesh mesh = test::random_mesh(4);
    BisectionForest start(mesh);
    std::vector<LeafId> created;
    while (start.leaf_count() < 6000) start.refine(leaves_of(start), created);
    LeafId stale;
    for (LeafId id : created)
        if (id.value >= mesh.halfedge_count() && start.can_merge(id)) stale = id;
    REQUIRE(stale.valid());
    start.merge(stale);
    const ExportedTriangles before = start.exported();
    const std::vector<LeafId> marked = leaves_of(start);
    std::vector<LeafId> repeated = marked, expected_created;
    repeated.insert(repeated.end(), marked.rbegin(), marked.rend());
    BisectionForest expected = start;
    expected.refine(marked, expected_created);
    for (const int threads : {1, 2, 7}) {
        CAPTURE(threads);
        RunContext context;
        context.threads = threads;
        with_threads(context, [&] {
            BisectionForest forest = start;
            for (const auto& [first, second] :
                 {std::pair{stale, LeafId(start.leaf_slots())}, std::pair{LeafId(start.leaf_slots()), stale}}) {
                std::vector<LeafId> bad = marked;
                bad[3001] = second;
                bad[2000] = first;
                try {
                    forest.refine(bad, created);
                    FAIL("no error");
                } catch (const Error& e) {
                    CHECK(e.code() == ErrorCode::invalid_input);
                    CHECK(std::string(e.what()).find(' ' + std::to_string(first.value) + ' ') != std::string::npos);
                }
                check_sound(forest);
                check_same_export(forest.exported(), before);
            }
            forest.refine(repeated, created);
            CHECK(created == expected_created);
            check_sound(forest);
            check_same_export(forest.exported(), expected.exported());
        });
    }
}

TEST_CASE("a copy of a forest goes its own way") {
    const ControlMesh mesh = test::random_mesh(6);
    BisectionForest forest(mesh);
    std::vector<LeafId> created;
    forest.refine(leaves_of(forest), created);
    const BisectionForest checkpoint = forest;
    const ExportedTriangles before = forest.exported();
    for (int i = 0; i < 3; ++i) forest.refine(leaves_of(forest), created);
    check_same_export(checkpoint.exported(), before);
    forest = checkpoint;
    check_sound(forest);
    check_same_export(forest.exported(), before);
    forest.refine(leaves_of(forest), created);
    check_sound(forest);
}

TEST_SUITE_END();
