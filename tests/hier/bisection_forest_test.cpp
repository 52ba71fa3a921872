#include "../../hier/forest/bisection_forest.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <map>
#include <set>

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
    // Both triangles of the diamond are reported: beside each other across their bases.
    const std::array<LeafId, 2> parents = forest.merge(stale);
    REQUIRE(!forest.is_leaf(stale));
    REQUIRE(forest.is_leaf(parents[0]));
    CHECK(parents[1] == forest.leaf(parents[0]).neighbour[0]);
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

TEST_SUITE_END();
