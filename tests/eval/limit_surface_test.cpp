#include "../kit/hierarchy_helpers.hpp"
#include "../kit/patch_meshes.hpp"

#include "../../eval/estimate/hierarchy_estimator.hpp"
#include "../../eval/estimate/linear_bound.hpp"
#include "../../eval/patches/limit_surface.hpp"
#include "../../eval/surface/local_frame.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

using namespace tetrakis;
using test::Random;

TEST_SUITE_BEGIN("eval");

TEST_CASE_TEMPLATE("[inv1] a hierarchy whose limits come from patches has the mesh of one whose limits come from rules",
                   Family, QuadFamily, LoopFamily) {
    constexpr SchemeKind scheme = std::is_same_v<Family, LoopFamily> ? SchemeKind::loop : SchemeKind::catmull_clark;
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<Family>(seed);
        Hierarchy by_rules = make_hierarchy(mesh, name(scheme));
        Hierarchy by_patches =
            make_hierarchy(mesh, name(scheme), {.limit_positions = std::make_shared<LimitSurface>(mesh, scheme)});
        Random random(seed);
        test::random_changes(by_rules, 10, 8, random, [] {});
        by_patches.load(by_rules.saved());
        const HierarchyMesh expected = by_rules.to_mesh({.normals = true}),
                            found = by_patches.to_mesh({.normals = true});
        CHECK(found.sites == expected.sites);
        CHECK(found.mesh.face_vertices == expected.mesh.face_vertices);
        CHECK(test::same_bytes(found.mesh.normals, expected.mesh.normals));
        double worst = 0;
        for (std::size_t v = 0; v < expected.sites.size(); ++v)
            worst = std::max(worst, glm::length(found.mesh.positions[v] - expected.mesh.positions[v]));
        // Both round at every level: some thirty last bits.
        CHECK(worst <= 4e-15 * bounding_box(mesh.positions()).diagonal());
        CHECK(test::same_bytes(by_patches.to_mesh({.positions = MeshPositions::finest}).mesh.positions,
                               by_rules.to_mesh({.positions = MeshPositions::finest}).mesh.positions));
    }
}

TEST_CASE("[bad-input] a limit surface refuses points that it does not have") {
    const ControlMesh cube = load_control_mesh(TETRAKIS_SOURCE_DIR "/data/cube.obj");
    const ControlMesh tetrahedron = load_control_mesh(TETRAKIS_SOURCE_DIR "/data/tetrahedron.obj");
    const LimitSurface quads(cube, SchemeKind::catmull_clark), triangles(tetrahedron, SchemeKind::loop);
    const HalfedgeId h(0);
    CHECK_THROWS_AS(static_cast<void>(quads.evaluate(HalfedgeId(999), 0.5, 0.5)), Error);
    CHECK_THROWS_AS(static_cast<void>(quads.evaluate(h, 2, 0)), Error);
    CHECK_THROWS_AS(static_cast<void>(quads.evaluate(h, std::nan(""), 0)), Error);
    CHECK_THROWS_AS(static_cast<void>(triangles.evaluate(h, 0.75, 0.75)), Error);
    CHECK_THROWS_AS(static_cast<void>(triangles.evaluate(HalfedgeId(1), 0, 0)), Error);
    CHECK_THROWS_AS(static_cast<void>(quads.vertex({h, {3, 0}, 1})), Error);
    Vec3d out;
    const Site beyond{h, {0, 0}, k_max_level + 1};
    CHECK_THROWS_AS(quads.positions({&beyond, 1}, {&out, 1}), Error);
    CHECK(glm::length(quads.evaluate(h, 1, 1).position - quads.vertex({h, {1, 1}, 0}).position) < 1e-14);
}

TEST_CASE("[inv9] what rounding adds to points far from the origin and deep in the tree is below what bounds allow") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const auto compare = [&]<class Family>(Family, SchemeKind scheme) {
            const ControlMesh here = test::random_patch_mesh<Family>(seed);
            ControlMeshData moved = here.data();
            const Vec3d by(1e6, -2e6, 3e6);
            for (Vec3d& p : moved.positions) p += by;
            const ControlMesh there = ControlMesh::build(std::move(moved));
            const LimitSurface a(here, scheme), b(there, scheme);
            const double most = detail::surface_rounding(there);
            Random random(seed);
            std::vector<Site> sites;
            for (int i = 0; i < 200; ++i) {
                const auto level = static_cast<std::uint8_t>(20 + random.below(9));
                const auto near = [&] { return static_cast<std::uint32_t>(random.below(4)); };
                const HalfedgeId root(static_cast<std::uint32_t>(random.below(here.halfedge_count())));
                sites.push_back({std::is_same_v<Family, LoopFamily> ? here.face_halfedge(here.face(root)) : root,
                                 {near(), near()},
                                 level});
            }
            std::vector<Vec3d> p(sites.size()), q(sites.size());
            a.positions(sites, p);
            b.positions(sites, q);
            for (std::size_t i = 0; i < sites.size(); ++i) CHECK(glm::length(p[i] + by - q[i]) <= most);
        };
        compare(QuadFamily{}, SchemeKind::catmull_clark);
        compare(LoopFamily{}, SchemeKind::loop);
    }
}

TEST_SUITE_END();
