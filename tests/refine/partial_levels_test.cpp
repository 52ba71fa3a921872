#include "../kit/input_helpers.hpp"

#include "../../refine/points/partial_levels.hpp"
#include "../../refine/rules/rule_refiner.hpp"

#include <doctest/doctest.h>

using namespace tetrakis;

TEST_SUITE_BEGIN("refine");

TEST_CASE("partial levels: twenty-five levels down at one spot, with a few hundred faces on each") {
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.refinement == Refinement::sqrt3 || scheme.refinement == Refinement::honeycomb) continue;
        CAPTURE(scheme.name);
        const ControlMesh mesh = test::mesh_for(scheme, test::model("cube"));
        const PartialLevels partial(mesh, scheme);
        constexpr int k_level = 25;
        LevelCost cost;
        Vec3d control(0);
        LimitPoint limit;
        // Two thirds of the way along a side are no vertex of any coarser level.
        const LatticePoint at{(1u << k_level) / 3, (1u << k_level) / 5};
        if (partial.lattice() == FanLattice::dual) {
            const VertexCell cell{5, at, k_level};
            partial.control_positions({&cell, 1}, {&control, 1}, &cost);
            partial.limits({&cell, 1}, {&limit, 1});
        } else {
            const Site site{HalfedgeId(3), at, k_level};
            partial.control_positions({&site, 1}, {&control, 1}, &cost);
            partial.limits({&site, 1}, {&limit, 1});
        }
        CHECK(cost.most_faces < 500);
        // So deep, the net lies on its limit.
        CHECK(glm::length(control - limit.position) < 1e-6);
        if (scheme.smoothness != "C0") CHECK(glm::length(limit.normal) == doctest::Approx(1));
    }
}

TEST_CASE("[bad-input] partial levels name the address that is wrong") {
    const ControlMesh mesh = test::model("cube");
    const PartialLevels quads(mesh, *find_scheme("kobbelt")), dual(mesh, *find_scheme("doo-sabin"));
    Vec3d out;
    const auto says = [](auto&& call, const char* what) { CHECK(test::contains(test::error_of(call).what(), what)); };
    const Site outside{HalfedgeId(0), {5, 0}, 2}, no_root{HalfedgeId(500), {0, 0}, 0}, fine{HalfedgeId(0), {0, 0}, 0};
    const VertexCell cell{0, {4, 0}, 2};
    says([&] { quads.control_positions({&outside, 1}, {&out, 1}); }, "outside its root");
    says([&] { quads.control_positions({&no_root, 1}, {&out, 1}); }, "no such root");
    says([&] { dual.control_positions({&cell, 1}, {&out, 1}); }, "outside its root");
    says([&] { dual.control_positions({&fine, 1}, {&out, 1}); }, "named by cells");
    says([&] { quads.control_positions({&fine, 1}, std::span<Vec3d>()); }, "needed");
    says([&] { PartialLevels(mesh, *find_scheme("sqrt3")); }, "no lattice");
    says([&] { PartialLevels(mesh, *find_scheme("loop")); }, "triangles");
    RuleOptions recede;
    recede.averaging_boundary = AveragingBoundary::recede;
    says([&] { PartialLevels(mesh, *find_scheme("biquartic"), recede); }, "recedes");
}

TEST_SUITE_END();
