#include "../kit/hierarchy_helpers.hpp"
#include "../kit/point_sets.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/sqrt3_forest.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/adaptive_sqrt3.hpp"
#include "../../refine/adaptive/sqrt3_points.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

using namespace tetrakis;

namespace {

using test::RandomMeshOptions;

std::vector<std::vector<std::uint32_t>> triangles(const PolygonMesh& mesh) {
    std::vector<std::vector<std::uint32_t>> result;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        result.emplace_back(mesh.face_vertices.begin() + 3 * f, mesh.face_vertices.begin() + 3 * f + 3);
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

namespace {

/// A closed mesh with all that can be tagged: a crease around, one that crosses it, ends of creases, corners.
ControlMesh tagged_mesh(float sharpness) {
    RandomMeshOptions options;
    options.topology = test::Topology::torus;
    options.columns = options.rows = 6;
    options.triangles_only = true;
    options.hole = options.crease = options.corner = 0;
    options.removed_faces = 0;
    ControlMeshData data = test::random_mesh(5, options).data();
    const auto vertex = [](std::uint32_t x, std::uint32_t y) { return y % 6 * 6 + x % 6; };
    for (std::uint32_t i = 0; i < 6; ++i) data.creases.push_back({vertex(i, 1), vertex(i + 1, 1), sharpness, 0});
    for (std::uint32_t i = 0; i < 4; ++i) data.creases.push_back({vertex(2, i), vertex(2, i + 1), sharpness, 0});
    data.creases.push_back({vertex(5, 3), vertex(5, 4), sharpness, 0});  // both of its ends are darts
    data.corners.push_back({vertex(4, 1), sharpness, 0});                // on a crease
    data.corners.push_back({vertex(0, 4), sharpness, 0});                // on a smooth surface
    return ControlMesh::build(data);
}

}  // namespace

TEST_CASE("[inv1] adaptive sqrt3: creases that close, cross and end, corners inside, whatever their sharpness") {
    for (const float sharpness : {10.0f, 0.4f, 1.0f, 1.7f}) {
        CAPTURE(sharpness);
        const ControlMesh mesh = tagged_mesh(sharpness);
        const double size = mesh.bounding_box().diagonal();
        Sqrt3Forest forest(mesh);
        ForestChange change;
        RefineOptions limit;
        limit.limit = true;
        std::vector<Vec3d> before;
        for (int level = 0; level <= 3; ++level) {
            const Sqrt3Mesh net = sqrt3_mesh(forest, {.limit = false}), limits = sqrt3_mesh(forest);
            const PolygonMesh uniform = refine(mesh, "sqrt3", level), on_limit = refine(mesh, "sqrt3", level, limit);
            REQUIRE(net.mesh.positions.size() == uniform.positions.size());
            CHECK(test::farthest_from(net.mesh.positions, uniform.positions) < 1e-12 * size);
            CHECK(test::farthest_from(limits.mesh.positions, on_limit.positions) < 1e-12 * size);
            // A limit is the same from all levels.
            CHECK(test::farthest_from(before, on_limit.positions) < 1e-12 * size);
            before = on_limit.positions;
            for (int step = 0; step < 2; ++step) forest.refine(forest.ordered_leaves(), change);
        }
    }
}

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
    CHECK(!forest.check().has_value());
    const Sqrt3Mesh out = sqrt3_mesh(forest, {.normals = true});
    CHECK(out.mesh.face_count() < 30 * 40);
    CHECK(test::topology(triangles(out.mesh)) == test::surface_topology(mesh));
    for (const Vec3d& n : out.mesh.normals) CHECK(glm::length(n) == doctest::Approx(1));
    CHECK(forest.memory_bytes() < 64 * out.mesh.face_count() + 4096);
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
    CHECK(!slots.check());
    // Its slots are dead now.
    CHECK_THROWS_AS(slots.refine({&children[0], 1}, change), Error);
    CHECK_THROWS_AS(slots.coarsen({&children[0], 1}, change, removed), Error);
    CHECK(!slots.check());
}

TEST_SUITE_END();
