#include "../../hier/forest/bisection_forest.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

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

void check_sound(const BisectionForest& forest) {
    const auto fault = check_forest(forest);
    CHECK_MESSAGE(!fault, fault.value_or(""));
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

TEST_CASE("a batch creates the parts of the marked leaves in their order, each's in path order, then those of others") {
    for (std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = small_mesh(seed);
        Random random(seed);
        BisectionForest forest = random_forest(mesh, random);
        std::vector<LeafId> marked = random_subset(forest.ordered_leaves(), 0.3, random), created;
        random.shuffle(marked);
        std::map<Node, std::size_t> rank;
        for (std::size_t i = 0; i < marked.size(); ++i) rank[node_of(forest, marked[i])] = i;
        forest.refine(marked, created);
        std::pair<std::size_t, Node> before{};
        for (const LeafId id : created) {
            const Node part = node_of(forest, id);
            Node whole = part;
            while (whole.depth > 0 && !rank.contains(whole)) {
                --whole.depth;
                whole.aligned = whole.depth == 0 ? 0 : whole.aligned >> (64 - whole.depth) << (64 - whole.depth);
            }
            const std::size_t r = rank.contains(whole) ? rank[whole] : marked.size();
            CHECK(r >= before.first);
            if (r == before.first && r < marked.size()) CHECK(part >= before.second);
            before = {r, part};
        }
    }
}

TEST_CASE("points beside holes have their sites in cells of the surface") {
    for (std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        test::RandomMeshOptions options = test::random_options(seed);
        options.hole = 0.3;
        const ControlMesh mesh = test::random_mesh(seed, options);
        Random random(seed);
        const ExportedTriangles out = random_forest(mesh, random).exported();
        for (const Site& site : out.sites) CHECK(!mesh.is_hole(mesh.face(site.root)));
    }
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
            const std::uint32_t leaves = forest.leaf_count(), midpoints = forest.midpoint_count();
            const bool has_room = leaves + cost.leaves <= capacity;
            const Snapshot before(forest);
            int reported = 0;
            REQUIRE(forest.split_diamond(id, [&](const Diamond&) { ++reported; }) == has_room);
            CHECK(forest.leaf_count() <= capacity);
            CHECK(forest.memory_bytes() == bytes);
            check_sound(forest);
            CHECK(forest.leaf_count() == leaves + (has_room ? cost.leaves : 0));
            CHECK(forest.midpoint_count() == midpoints + (has_room ? cost.midpoints : 0));
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

TEST_CASE("repeated marks count once") {
    const ControlMesh mesh = test::random_mesh(4);
    BisectionForest start(mesh);
    std::vector<LeafId> created, expected_created;
    while (start.leaf_count() < 6000) start.refine(start.ordered_leaves(), created);
    const std::vector<LeafId> marked = start.ordered_leaves();
    std::vector<LeafId> repeated = marked;
    repeated.insert(repeated.end(), marked.rbegin(), marked.rend());
    BisectionForest expected = start;
    expected.refine(marked, expected_created);
    start.refine(repeated, created);
    CHECK(created == expected_created);
    check_sound(start);
    const ExportedTriangles out = start.exported(), same = expected.exported();
    CHECK(out.triangles == same.triangles);
    CHECK(out.sites == same.sites);
}

TEST_SUITE_END();
