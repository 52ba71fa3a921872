#include "../kit/point_sets.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/closure.hpp"
#include "../../refine/adaptive/partial_levels.hpp"
#include "../../refine/rules/rule_refiner.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>

using namespace tetrakis;

namespace {

ControlMesh cube() {
    return ControlMesh::build(read_obj(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / "cube.obj"));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("partial levels: twenty-five levels down at one spot, with a few hundred faces on each") {
    for (const SchemeInfo& scheme : scheme_table()) {
        if (scheme.refinement == Refinement::sqrt3 || scheme.refinement == Refinement::honeycomb) continue;
        CAPTURE(scheme.name);
        const ControlMesh mesh = scheme.family == MeshFamily::triangles ? triangulate(cube()) : cube();
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
    const ControlMesh mesh = cube();
    const PartialLevels quads(mesh, *find_scheme("kobbelt")), dual(mesh, *find_scheme("doo-sabin"));
    Vec3d out;
    const auto message = [](auto&& call) -> std::string {
        try {
            call();
        } catch (const Error& e) {
            return e.what();
        }
        return {};
    };
    const Site outside{HalfedgeId(0), {5, 0}, 2}, no_root{HalfedgeId(500), {0, 0}, 0}, fine{HalfedgeId(0), {0, 0}, 0};
    const VertexCell cell{0, {4, 0}, 2};
    CHECK(message([&] { quads.control_positions({&outside, 1}, {&out, 1}); }).find("outside its root") < 999);
    CHECK(message([&] { quads.control_positions({&no_root, 1}, {&out, 1}); }).find("no such root") < 999);
    CHECK(message([&] { dual.control_positions({&cell, 1}, {&out, 1}); }).find("outside its root") < 999);
    CHECK(message([&] { dual.control_positions({&fine, 1}, {&out, 1}); }).find("named by cells") < 999);
    CHECK(message([&] { quads.control_positions({&fine, 1}, std::span<Vec3d>()); }).find("needed") < 999);
    CHECK(message([&] { PartialLevels(mesh, *find_scheme("sqrt3")); }).find("no lattice") < 999);
    CHECK(message([&] { PartialLevels(mesh, *find_scheme("loop")); }).find("triangles") < 999);
    RuleOptions recede;
    recede.averaging_boundary = AveragingBoundary::recede;
    CHECK(message([&] { PartialLevels(mesh, *find_scheme("biquartic"), recede); }).find("recedes") < 999);
}

TEST_SUITE_END();
