#include "../kit/hierarchy_helpers.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("refine");

TEST_CASE("sqrt3 forests take less than 64 bytes a leaf") {
    const ControlMesh mesh = triangulate(load_control_mesh(TETRAKIS_SOURCE_DIR "/data/cube.obj"));
    Sqrt3Forest forest(mesh);
    ForestChange change;
    for (int i = 0; i < 10; ++i) forest.refine(forest.ordered_leaves(), change);
    CHECK(forest.memory_bytes() < 64 * std::uint64_t{forest.leaf_count()});
}

TEST_CASE("[bad-input] sqrt3 slots refuse stale handles, and coarsen after their spare room is given back") {
    const ControlMesh mesh = test::random_sqrt3_mesh(1);
    Sqrt3Forest slots(mesh);
    ForestChange change, ignored;
    Sqrt3Forest::Changed removed;
    const LeafId root(4);
    slots.refine({&root, 1}, change, &removed);
    const std::vector<LeafId> children(change.created.begin(), change.created.begin() + 3);
    const std::vector<LeafId> before = slots.ordered_leaves();
    for (const LeafId stale : {root, LeafId(1'000'000), LeafId{}}) {
        const std::vector<LeafId> marked{children[0], stale};
        CHECK_THROWS_AS(slots.refine(marked, ignored), Error);
        CHECK_THROWS_AS(slots.coarsen(marked, ignored, removed), Error);
    }
    CHECK(slots.ordered_leaves() == before);
    slots.shrink();
    slots.coarsen(children, change, removed);
    CHECK(slots.is_leaf(root));
    CHECK(!check_forest(slots));
    // Its slots are dead now.
    CHECK_THROWS_AS(slots.refine({&children[0], 1}, change), Error);
    CHECK_THROWS_AS(slots.coarsen({&children[0], 1}, change, removed), Error);
    CHECK(!check_forest(slots));
}

TEST_SUITE_END();
