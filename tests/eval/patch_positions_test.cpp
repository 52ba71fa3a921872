#include "../kit/hierarchy_helpers.hpp"

#include "../../eval/bounds/linear_bound.hpp"
#include "../../eval/surface/patch_positions.hpp"
#include "../../eval/tessellate/hierarchy_estimator.hpp"

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
static_assert(takes_what_stays<PatchPositions, ControlMesh, SchemeKind>);
static_assert(takes_what_stays<LinearBound, ControlMesh, const SchemeInfo&>);
static_assert(takes_what_stays<HierarchyEstimator, Hierarchy, double>);

namespace {

/// Random polygons or triangles, most with a boundary, with creases, semi-sharp ones among them, and corners.
ControlMesh tagged_mesh(SchemeKind scheme, std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.crease = seed % 3 == 0 ? 0.4 : 0.15;
    options.triangles_only = scheme == SchemeKind::loop;
    ControlMeshData data = test::random_mesh_data(seed, options);
    if (seed % 2 == 0) data.crease_method = CreaseMethod::chaikin;
    return ControlMesh::build(std::move(data));
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[inv1] a hierarchy whose limits come from patches has the mesh of one whose limits come from rules") {
    std::size_t semi_sharp = 0, open = 0;
    for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop})
        for (const std::uint64_t seed : test::seeds(8)) {
            INFO(name(scheme));
            CAPTURE(seed);
            const ControlMesh mesh = tagged_mesh(scheme, seed);
            for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
                const float sharpness = mesh.sharpness(EdgeId(e));
                semi_sharp += is_sharp(sharpness) && sharpness < 10 ? 1 : 0;
                open += mesh.is_boundary(EdgeId(e)) ? 1 : 0;
            }
            Hierarchy by_rules = make_hierarchy(mesh, name(scheme));
            Hierarchy by_patches =
                make_hierarchy(mesh, name(scheme), {.limit_positions = std::make_shared<PatchPositions>(mesh, scheme)});
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
    CHECK(semi_sharp > 0);
    CHECK(open > 0);
}

TEST_SUITE_END();
