#include "../kit/input_helpers.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

/// A grid of quads that is large enough for rows to be learned, with a hole and an isolated vertex if they are asked
/// for.
ControlMesh grid_for(const SchemeInfo& scheme, bool gaps) {
    ControlMeshData data = test::skewed_grid(6);
    if (gaps) data.holes = {0, 15};
    if (gaps) data.positions.emplace_back(0, 0, 50);
    return test::mesh_for(scheme, ControlMesh::build(std::move(data)));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("positions refined again: corner angles that were measured stay") {
    ControlMeshData data = test::random_mesh_data(1, {.columns = 3, .rows = 3, .corner = 0.3});
    const ControlMesh mesh = ControlMesh::build(data);
    test::Random random(5);
    for (Vec3d& p : data.positions) p += 0.4 * Vec3d(random.uniform(), random.uniform(), random.uniform());
    const ControlMesh other = ControlMesh::build(std::move(data));
    const RefineOptions options{.rules = {.measure_corner_angles = true}};
    const PositionRefiner refiner(mesh, "catmull-clark", 2, options);
    const StencilTable table = refine_stencils(mesh, scheme_named("catmull-clark"), 2, options).stencils;
    std::vector<Vec3d> positions(refiner.mesh().positions.size()), expected = positions;
    refiner.refine(other.positions(), positions);
    table.apply<Vec3d>(other.positions(), expected);
    double most = 0;
    for (std::size_t v = 0; v < positions.size(); ++v) most = std::max(most, glm::length(expected[v] - positions[v]));
    CHECK(most < 1e-13);
    CHECK(!test::same_bytes(positions, refine(other, "catmull-clark", 2, options).positions));
}

TEST_CASE("[bad-input] position refiners refuse what refine() does, and spans of the wrong length") {
    const SchemeInfo& doo_sabin = scheme_named("doo-sabin");
    const ControlMesh mesh = grid_for(doo_sabin, true);
    const auto message = [](auto&& call) {
        const Error error = test::error_of(call);
        CHECK(error.code() == ErrorCode::invalid_input);
        return std::string(error.what());
    };
    CHECK(message([&] { PositionRefiner(mesh, "catmul", 1); }).find("catmull-clark") != std::string::npos);
    CHECK(message([&] { PositionRefiner(mesh, doo_sabin, -1); }).find("negative") != std::string::npos);
    CHECK(message([&] { PositionRefiner(mesh, "loop", 1); }).find("triangulate") != std::string::npos);
    for (const char* name : {"catmull-clark", "doo-sabin", "honeycomb", "bilinear"}) {
        CAPTURE(name);
        const PositionRefiner plain(mesh, name, 3);
        const PositionRefiner both(mesh, name, 3, {.normals = std::string(name) != "bilinear"});
        const std::size_t count = plain.mesh().positions.size();
        std::vector<Vec3d> right(count, Vec3d(1)), wrong(count + 1, Vec3d(1)), untouched = right;
        const std::string expected = std::to_string(count) + " are needed";
        CHECK(message([&] { plain.refine(mesh.positions(), wrong); }).find(expected) != std::string::npos);
        CHECK(message([&] { plain.refine(mesh.positions(), {}); }).find(expected) != std::string::npos);
        CHECK(message([&] { plain.refine(std::span(wrong).first(4), right); }).find("control") != std::string::npos);
        CHECK(message([&] { plain.refine(mesh.positions(), right, untouched); }).find("normals") != std::string::npos);
        CHECK(message([&] { both.refine(mesh.positions(), right, wrong); }).find("normals") != std::string::npos);
        CHECK(test::same_bytes(right, untouched));
    }
}

TEST_CASE("positions refined again can be cancelled") {
    for (const char* scheme : {"4-8", "catmull-clark"}) {
        bool go_on = true;
        RefineOptions options;
        options.context.progress = [&](std::string_view, double) { return go_on; };
        const ControlMesh mesh = grid_for(scheme_named(scheme), false);
        const PositionRefiner refiner(mesh, scheme, 5, options);
        std::vector<Vec3d> positions(refiner.mesh().positions.size());
        CHECK_NOTHROW(refiner.refine(mesh.positions(), positions));
        go_on = false;
        CHECK_THROWS_AS(refiner.refine(mesh.positions(), positions), Error);
        go_on = true;
        refiner.refine(mesh.positions(), positions);
        CHECK(test::same_bytes(positions, refiner.mesh().positions));
    }
}

TEST_SUITE_END();
