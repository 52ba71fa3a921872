#include "../kit/corner_angle_mesh.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/point_match.hpp"
#include "../kit/scheme_meshes.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../eval/surface/quad_patches.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <optional>
#include <string_view>

using namespace tetrakis;
using test::contains;
using test::error_of;
using test::radians;
using test::triangles_of;

TEST_SUITE_BEGIN("eval");

TEST_CASE("[slow] [inv1] [inv9] tessellations have the vertices that refine() has where corners have angles") {
    struct Case {
        std::string_view scheme;
        bool measured;
        EstimatorKind estimator;
    };
    for (const Case& c :
         {Case{"loop", false, EstimatorKind::certified}, Case{"catmull-clark", true, EstimatorKind::measured}}) {
        CAPTURE(c.scheme);
        const ControlMesh mesh =
            test::with_angles(test::sheet(c.scheme == "loop"), [&](HalfedgeId h) -> std::optional<double> {
                if (h.value % 2 == 0 && c.measured) return std::nullopt;
                return radians(h.value % 2 == 0 ? 110 : 260);
            });
        REQUIRE(mesh.has_corner_angles());
        RuleOptions rules;
        rules.measure_corner_angles = c.measured;
        const Tessellation result = tessellate(mesh, {.scheme = c.scheme,
                                                      .rules = rules,
                                                      .estimator = c.estimator,
                                                      .tolerance = 1e-2,
                                                      .max_level = 3,
                                                      .measure = false});
        CHECK(result.mesh.uvs.size() >= result.mesh.positions.size());
        std::vector<Vec3d> points;
        const int deepest = result.deepest_level + 1;
        for (int level = 1; level <= deepest; ++level) {
            const auto uniform = refine(mesh, c.scheme, level, {.rules = rules, .limit = true}).positions;
            points.insert(points.end(), uniform.begin(), uniform.end());
        }
        const PointMatch match(points);
        double worst = 0;
        for (const Vec3d& p : result.mesh.positions) worst = std::max(worst, glm::length(p - points[match.nearest(p)]));
        CHECK(worst < 1e-10);
        if (c.estimator != EstimatorKind::certified) continue;
        REQUIRE(result.certified_error);
        CHECK(*result.certified_error < 10 * result.tolerance_absolute);
        const TriangleMesh reference =
            triangles_of(refine(mesh, c.scheme, deepest + 1, {.rules = rules, .limit = true}));
        CHECK(compare_meshes(reference, result.mesh, {.samples = 10'000}).hausdorff <= *result.certified_error);
    }
}

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
