#include "../kit/hierarchy_helpers.hpp"
#include "../kit/patch_meshes.hpp"

#include "../../eval/estimate/hierarchy_estimator.hpp"
#include "../../eval/estimate/linear_bound.hpp"
#include "../../eval/patches/limit_surface.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <memory>
#include <type_traits>

using namespace tetrakis;
using test::Random;

// What keeps a reference to a mesh or a hierarchy takes one that stays, and no temporary.
template <class Keeper, class Kept, class... Rest>
constexpr bool takes_what_stays =
    std::is_constructible_v<Keeper, const Kept&, Rest...> && !std::is_constructible_v<Keeper, Kept, Rest...>;
static_assert(takes_what_stays<QuadPatches, ControlMesh>);
static_assert(takes_what_stays<LoopPatches, ControlMesh>);
static_assert(takes_what_stays<LimitSurface, ControlMesh, SchemeKind>);
static_assert(takes_what_stays<LinearBound, ControlMesh, const SchemeInfo&>);
static_assert(takes_what_stays<HierarchyEstimator, Hierarchy, double>);

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

TEST_SUITE_END();
