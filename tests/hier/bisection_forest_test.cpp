#include "../../hier/forest/bisection_forest.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/check.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <map>
#include <set>

using namespace tetrakis;
using test::Random;
using test::random_subset;

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

/// The nodes of the leaves by their slots.
std::map<std::uint32_t, Node> nodes_of(const BisectionForest& forest) {
    std::map<std::uint32_t, Node> nodes;
    for (const LeafId id : forest.ordered_leaves()) nodes.emplace(id.value, node_of(forest, id));
    return nodes;
}

void check_same_export(const ExportedTriangles& a, const ExportedTriangles& b) {
    CHECK(a.triangles == b.triangles);
    CHECK(a.faces == b.faces);
    CHECK(a.sites == b.sites);
}

void check_sound(const BisectionForest& forest) {
    const auto fault = check_forest(forest);
    CHECK_MESSAGE(!fault, fault.value_or(""));
}

/// What refine() promises: the parts of the marked leaves in their order, then those of other leaves, in path order.
void check_order(const std::vector<LeafId>& created, const std::vector<LeafId>& marked,
                 const std::map<std::uint32_t, Node>& old, const BisectionForest& forest) {
    std::vector<std::pair<Node, Node>> parts;  // a leaf of before, and its part
    std::set<Node> before;
    for (const auto& [slot, node] : old) before.insert(node);
    for (const LeafId id : created) {
        const Node part = node_of(forest, id);
        Node whole = part;
        while (before.count(whole) == 0) {
            REQUIRE(whole.depth > 0);
            --whole.depth;
            whole.aligned = whole.depth == 0 ? 0 : whole.aligned >> (64 - whole.depth) << (64 - whole.depth);
        }
        if (!parts.empty() && parts.back().first == whole) CHECK(parts.back().second < part);
        parts.emplace_back(whole, part);
    }
    std::vector<Node> wholes;
    for (const auto& [whole, part] : parts)
        if (wholes.empty() || wholes.back() != whole) wholes.push_back(whole);
    REQUIRE(wholes.size() >= marked.size());
    for (std::size_t i = 0; i < marked.size(); ++i) CHECK(wholes[i] == old.at(marked[i].value));
    CHECK(std::set<Node>(wholes.begin(), wholes.end()).size() == wholes.size());
}

/// All leaves and points with their numbers and links.
struct Snapshot {
    explicit Snapshot(const BisectionForest& forest) {
        for (LeafId id : forest.ordered_leaves()) {
            const BisectionLeaf& l = forest.leaf(id);
            leaves.push_back({id, l.neighbour, l.vertex, node_of(forest, id)});
        }
        for (std::uint32_t p = 0; p < forest.point_slots(); ++p)
            if (forest.is_point(PointId(p))) points.emplace_back(p, forest.point_site(PointId(p)));
    }
    friend bool operator==(const Snapshot&, const Snapshot&) = default;

    struct Leaf {
        LeafId id;
        std::array<LeafId, 3> neighbour;
        std::array<PointId, 3> vertex;
        Node node;
        friend bool operator==(const Leaf&, const Leaf&) = default;
    };
    std::vector<Leaf> leaves;
    std::vector<std::pair<std::uint32_t, Site>> points;
};

/// A small mesh with boundary and holes, and a forest of it after a few random batches.
ControlMesh small_mesh(std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 4;
    options.boundary_rule = BoundaryRule::edge_and_corner;  // "none" may leave no face
    return test::random_mesh(seed, options);
}
BisectionForest random_forest(const ControlMesh& mesh, Random& random) {
    BisectionForest forest(mesh);
    std::vector<LeafId> created;
    for (int pass = 0; pass < 4; ++pass) forest.refine(random_subset(forest.ordered_leaves(), 0.1, random), created);
    forest.coarsen(random_subset(forest.ordered_leaves(), 0.8, random), created);
    return forest;
}

}  // namespace

TEST_SUITE_BEGIN("hier");

TEST_CASE("[inv5] merging what a split has reported, in reverse, gives back every slot, link and point") {
    int with_closure = 0, at_boundary = 0;
    for (std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = small_mesh(seed);
        Random random(seed);
        BisectionForest forest = random_forest(mesh, random);
        forest.reserve(forest.leaf_count() + 200);
        for (LeafId id : random_subset(forest.ordered_leaves(), 0.3, random)) {
            const Snapshot before(forest);
            std::vector<Diamond> first, second;
            REQUIRE(forest.split_diamond(id, [&](const Diamond& d) { first.push_back(d); }));
            const Snapshot between(forest);
            CHECK(between != before);
            with_closure += first.size() > 1;
            for (std::size_t i = first.size(); i-- > 0;) {
                at_boundary += first[i].pair_count == 1;
                // Any leaf names the diamond.
                const auto& pair = first[i].pairs[random.below(first[i].pair_count)];
                const LeafId leaf = pair[random.below(2)];
                REQUIRE(forest.can_merge(leaf));
                REQUIRE(forest.merge_diamond(leaf, [&](const Diamond& d) {
                    CHECK(d.midpoint == first[i].midpoint);
                    CHECK(d.pair_count == first[i].pair_count);
                    CHECK(d.pairs == first[i].pairs);
                }));
                check_sound(forest);
            }
            CHECK(Snapshot(forest) == before);
            // The same slots again.
            REQUIRE(forest.split_diamond(id, [&](const Diamond& d) { second.push_back(d); }));
            CHECK(Snapshot(forest) == between);
            for (std::size_t i = second.size(); i-- > 0;)
                REQUIRE(forest.merge_diamond(second[i].pairs[0][1], [](const Diamond&) {}));
        }
        // The same for batches.
        const Snapshot before(forest);
        const std::uint32_t midpoints = forest.midpoint_count();
        std::vector<LeafId> created, parents;
        std::set<Node> old;
        for (LeafId id : forest.ordered_leaves()) old.insert(node_of(forest, id));
        forest.refine(forest.ordered_leaves(), created);
        while (forest.midpoint_count() > midpoints) {
            std::erase_if(created,
                          [&](LeafId id) { return !forest.is_leaf(id) || old.count(node_of(forest, id)) != 0; });
            REQUIRE(forest.coarsen(created, parents) > 0);
            check_sound(forest);
        }
        CHECK(Snapshot(forest) == before);
    }
    CHECK(with_closure > 0);
    CHECK(at_boundary > 0);
}

TEST_CASE("a split beyond the capacity is refused and changes nothing") {
    int refused_closures = 0;
    for (std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = small_mesh(seed);
        Random random(seed);
        BisectionForest forest = random_forest(mesh, random);
        forest.shrink();
        const std::uint32_t capacity = std::max(forest.leaf_capacity(), forest.leaf_count() + 100);
        forest.reserve(capacity);
        REQUIRE(forest.leaf_capacity() == capacity);
        const std::uint64_t bytes = forest.memory_bytes();
        for (int refused = 0; refused < 20;) {
            const auto ids = forest.ordered_leaves();
            const LeafId id = ids[random.below(static_cast<std::uint32_t>(ids.size()))];
            const auto cost = forest.split_cost(id);
            const bool has_room = forest.leaf_count() + cost.leaves <= capacity;
            const Snapshot before(forest);
            int reported = 0;
            REQUIRE(forest.split_diamond(id, [&](const Diamond&) { ++reported; }) == has_room);
            CHECK(forest.leaf_count() <= capacity);
            CHECK(forest.memory_bytes() == bytes);
            check_sound(forest);
            if (has_room) continue;
            ++refused;
            CHECK(reported == 0);
            CHECK(Snapshot(forest) == before);
            // The first split of the closure had room.
            refused_closures += cost.midpoints > 1 && forest.leaf_count() + 2 <= capacity;
        }
        // Batches make room.
        std::vector<LeafId> created;
        forest.refine(forest.ordered_leaves(), created);
        CHECK(forest.leaf_count() > capacity);
        CHECK(forest.leaf_capacity() >= forest.leaf_count());
        check_sound(forest);
    }
    CHECK(refused_closures > 0);
}

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
            const auto marked = random_subset(forest.ordered_leaves(), 0.15, random);
            const std::map<std::uint32_t, Node> old = nodes_of(forest);
            for (LeafId id : marked) naive.split(node_of(forest, id));
            naive.close();
            forest.refine(marked, created);
            check_sound(forest);
            std::set<Node> leaves;
            for (const auto& [slot, node] : nodes_of(forest)) leaves.insert(node);
            REQUIRE(leaves == naive.leaves);
            check_order(created, marked, old, forest);
            // `created` are exactly the leaves that were none before.
            std::set<std::uint32_t> fresh;
            for (LeafId id : created) REQUIRE(fresh.insert(id.value).second);
            for (LeafId id : forest.ordered_leaves()) {
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
    const auto roots = forest.ordered_leaves();
    std::vector<LeafId> created;
    forest.refine(roots, created);
    // A slot above the roots that its diamond's merge frees.
    LeafId stale;
    for (LeafId id : created)
        if (id.value >= mesh.halfedge_count() && forest.can_merge(id)) stale = id;
    REQUIRE(stale.valid());
    // Both triangles are reported: beside each other across their bases.
    std::vector<Diamond> merged;
    REQUIRE(forest.merge_diamond(stale, [&](const Diamond& d) { merged.push_back(d); }));
    REQUIRE(merged.size() == 1);
    REQUIRE(!forest.is_leaf(stale));
    REQUIRE(forest.is_leaf(merged[0].pairs[0][0]));
    CHECK(merged[0].pairs[1][0] == forest.leaf(merged[0].pairs[0][0]).neighbour[0]);
    const ExportedTriangles before = forest.exported();
    const auto ignore = [](const Diamond&) { FAIL("a change is reported"); };
    const auto fails = [&](auto&& call, LeafId id) {
        const Error e = test::error_of(call);
        CHECK(e.code() == ErrorCode::invalid_input);
        CHECK(test::contains(e.what(), std::to_string(id.value)));
        check_sound(forest);
        check_same_export(forest.exported(), before);
    };
    for (LeafId id : {stale, LeafId(forest.leaf_slots()), LeafId{}}) {
        CHECK(!forest.can_merge(id));
        const std::vector<LeafId> marked{roots.front(), id};
        fails([&] { forest.split_cost(id); }, id);
        fails([&] { forest.split_diamond(id, ignore); }, id);
        fails([&] { forest.merge_diamond(id, ignore); }, id);
        fails([&] { forest.coarsen(marked, created); }, id);
    }
    LeafId root;
    for (LeafId id : forest.ordered_leaves())
        if (forest.depth(id) == 0) root = id;
    REQUIRE(root.valid());
    CHECK(!forest.can_merge(root));
    CHECK(!forest.merge_diamond(root, ignore));
    check_same_export(forest.exported(), before);
}

TEST_CASE("[bad-input] [inv10] of thousands of marks the first bad one is named and repeated ones count once") {
    const ControlMesh mesh = test::random_mesh(4);
    BisectionForest start(mesh);
    std::vector<LeafId> created;
    while (start.leaf_count() < 6000) start.refine(start.ordered_leaves(), created);
    LeafId stale;
    for (LeafId id : created)
        if (id.value >= mesh.halfedge_count() && start.can_merge(id)) stale = id;
    REQUIRE(stale.valid());
    REQUIRE(start.merge_diamond(stale, [](const Diamond&) {}));
    const ExportedTriangles before = start.exported();
    const std::vector<LeafId> marked = start.ordered_leaves();
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
                const Error e = test::error_of([&] { forest.refine(bad, created); });
                CHECK(e.code() == ErrorCode::invalid_input);
                CHECK(test::contains(e.what(), ' ' + std::to_string(first.value) + ' '));
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
