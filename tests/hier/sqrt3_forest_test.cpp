#include "../kit/hierarchy_helpers.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/check.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../hier/trees/sqrt3_forest.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <doctest/doctest.h>

#include <array>
#include <filesystem>
#include <set>
#include <vector>

using namespace tetrakis;

TEST_SUITE_BEGIN("refine");

TEST_CASE("adaptive sqrt3: a zoom of 30 levels at one spot; 64 bytes a leaf") {
    const ControlMesh mesh =
        triangulate(ControlMesh::build(read_obj(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / "cube.obj")));
    Sqrt3Forest forest(mesh);
    REQUIRE(forest.max_level() >= 30);
    ForestChange change;
    std::uint64_t face = 2;
    for (std::uint8_t level = 0; level < 30; ++level) {
        for (const bool half : {true, false}) {  // a half one becomes whole first
            const LeafId leaf = forest.find({level, half, face});
            if (leaf.valid()) forest.refine({&leaf, 1}, change);
        }
        face = 3 * face + level % 3;
    }
    REQUIRE(forest.split_count() >= 30);
    CHECK(!check_forest(forest).has_value());
    std::vector<std::vector<std::uint32_t>> triangles;
    std::set<Site> sites;
    forest.for_each_leaf([&](LeafId leaf, FaceId) {
        triangles.emplace_back();
        const Sqrt3Cell cell = forest.lattice().cell(forest.triangle(leaf));
        const std::array<PointId, 3> points = forest.points(leaf);
        for (std::size_t k = 0; k < 3; ++k) {
            triangles.back().push_back(points[k].value);
            const Site site = forest.site(points[k]);
            CHECK(site == sqrt3_site(mesh, cell.root, cell.corner[k], cell.lattice()));
            sites.insert(site);
        }
    });
    CHECK(triangles.size() < 30 * 40);
    CHECK(test::topology(triangles) == test::surface_topology(mesh));
    const std::vector<Site> all(sites.begin(), sites.end());
    std::vector<Vec3d> normals(all.size());
    make_hierarchy(mesh, "sqrt3").normals(all, normals);
    for (const Vec3d& n : normals) CHECK(glm::length(n) == doctest::Approx(1));
    CHECK(forest.memory_bytes() < 64 * triangles.size() + 4096);
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
