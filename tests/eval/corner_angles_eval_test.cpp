#include "../kit/corner_angle_mesh.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/scheme_meshes.hpp"

#include "../../eval/patches/quad_patches.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

using namespace tetrakis;
using test::contains;
using test::error_of;
using test::triangles_of;

TEST_SUITE_BEGIN("eval");

TEST_CASE("[bad-input] corners with angles have no patches: what needs them is refused") {
    const ControlMesh mesh = test::with_mixed_angles(test::sheet(false), 3);
    CHECK(scheme_support(SchemeKind::catmull_clark).patches);
    CHECK(!scheme_support(mesh, SchemeKind::catmull_clark).patches);
    CHECK(scheme_support(mesh, SchemeKind::catmull_clark).certified);
    CHECK(scheme_support(test::sheet(false), SchemeKind::catmull_clark).patches);
    const Error patches = error_of([&] { QuadPatches{mesh}; });
    CHECK(patches.code() == ErrorCode::unsupported);
    CHECK(contains(patches.what(), "corner angles"));
    const TriangleMesh target = triangles_of(refine(mesh, "catmull-clark", 1));
    const Error projected = error_of([&] { tessellate(mesh, {.tolerance = 1e-2, .target = &target}); });
    CHECK(projected.code() == ErrorCode::unsupported);
    CHECK(contains(projected.what(), "corner angles"));
}

TEST_SUITE_END();
