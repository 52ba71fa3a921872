#include "../kit/input_helpers.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/same_bytes.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/adaptive/adaptive_dual.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../refine/points/sqrt3_points.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

using namespace tetrakis;

// What keeps a reference to a mesh takes one that stays, and no temporary.
template <class Refiner, class... Rest>
constexpr bool takes_meshes_that_stay = std::is_constructible_v<Refiner, const ControlMesh&, Rest...> &&
                                        !std::is_constructible_v<Refiner, ControlMesh, Rest...> &&
                                        !std::is_constructible_v<Refiner, const ControlMesh, Rest...>;
static_assert(takes_meshes_that_stay<PositionRefiner, const char*, int>);
static_assert(takes_meshes_that_stay<PositionRefiner, const SchemeInfo&, int, RefineOptions>);
static_assert(takes_meshes_that_stay<AdaptiveDual, const SchemeInfo&>);
static_assert(takes_meshes_that_stay<Sqrt3Points>);
template <class Mesh, class Scheme>
concept MakesHierarchy = requires(Mesh&& mesh, Scheme scheme) {
    make_hierarchy(std::forward<Mesh>(mesh), scheme);
    make_hierarchy(std::forward<Mesh>(mesh), scheme, {.rules = {}});
};
static_assert(MakesHierarchy<const ControlMesh&, const char*> && MakesHierarchy<ControlMesh&, const SchemeInfo&>);
static_assert(!MakesHierarchy<ControlMesh, const char*> && !MakesHierarchy<const ControlMesh, const SchemeInfo&>);

namespace {

/// With boundaries, creases and corners, holes and isolated vertices.
ControlMesh random_cage(std::uint64_t seed, const SchemeInfo& scheme) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 3;
    options.hole = 0.15;
    options.boundary_rule = BoundaryRule::edge_and_corner;
    ControlMeshData data = test::random_mesh_data(seed, options);
    // One before the others, one after them.
    data.positions.insert(data.positions.begin(), Vec3d(7, 8, 9));
    for (std::uint32_t& v : data.face_vertices) ++v;
    for (auto& tag : data.creases) ++tag.a, ++tag.b;
    for (auto& tag : data.corners) ++tag.vertex;
    data.positions.emplace_back(-7, 8, 9);
    return test::mesh_for(scheme, ControlMesh::build(std::move(data)));
}

/// The same mesh with every vertex elsewhere.
ControlMesh moved(const ControlMesh& mesh, std::uint64_t seed) {
    ControlMeshData data = mesh.data();
    test::Random random(seed);
    for (Vec3d& p : data.positions)
        p += Vec3d(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4));
    return ControlMesh::build(std::move(data));
}

struct Points {
    std::vector<Vec3d> positions, normals;
};

/// In buffers that hold something else before.
Points refined_again(const PositionRefiner& refiner, const ControlMesh& mesh) {
    const Vec3d nothing(std::numeric_limits<double>::quiet_NaN());
    Points points{std::vector<Vec3d>(refiner.mesh().positions.size(), nothing),
                  std::vector<Vec3d>(refiner.mesh().normals.size(), nothing)};
    refiner.refine(mesh.positions(), points.positions, points.normals);
    return points;
}

void check_moved(const ControlMesh& mesh, const SchemeInfo& scheme, int levels, const RefineOptions& options) {
    const PositionRefiner refiner(mesh, scheme, levels, options);
    const ControlMesh other = moved(mesh, 1);
    const PolygonMesh still = refine(mesh, scheme, levels, options), expected = refine(other, scheme, levels, options);
    CHECK(still.positions.size() > 100);
    CHECK(test::same_bytes(refiner.mesh().positions, still.positions));
    const Points points = refined_again(refiner, other);
    CHECK(test::same_bytes(points.positions, expected.positions));
    CHECK(test::same_bytes(points.normals, expected.normals));
    CHECK(!test::same_bytes(points.positions, still.positions));
    // The first mesh once more.
    CHECK(test::same_bytes(refined_again(refiner, mesh).positions, still.positions));
}

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

TEST_CASE("positions refined again: other rules, rounds of smoothing, attributes") {
    const auto check = [](const char* name, int levels, const RefineOptions& options, std::uint64_t seed) {
        CAPTURE(name);
        const SchemeInfo& scheme = scheme_named(name);
        check_moved(random_cage(seed, scheme), scheme, levels, options);
    };
    RefineOptions cosine, beta, even, smoothed{.smoothing = 2}, plain;
    cosine.rules.edge_beside_crease = EdgeBesideCrease::cosine;
    beta.rules.catmull_clark_beta = 0.4;
    even.rules.averaging_steps = 4;
    check("loop", 3, cosine, 1);
    check("catmull-clark", 3, beta, 1);
    check("averaging", 3, even, 1);
    check("kobbelt", 3, smoothed, 1);
    check("bilinear", 2, smoothed, 1);
    check("modified-butterfly", 3, smoothed, 3);

    const ControlMesh mesh = random_cage(1, scheme_named("4-8"));
    const VertexAttribute attribute{"weight", 2, std::vector<float>(2 * mesh.vertex_count(), 0.25f)};
    plain.attributes = {&attribute, 1};
    const PositionRefiner refiner(mesh, "4-8", 2, plain);
    REQUIRE(refiner.mesh().attributes.size() == 1);
    CHECK(refiner.mesh().attributes[0].values.size() == 2 * refiner.mesh().positions.size());
    CHECK(test::same_bytes(refined_again(refiner, mesh).positions, refine(mesh, "4-8", 2).positions));
}

TEST_CASE("positions refined again: corner angles that were measured stay") {
    const ControlMesh mesh = random_cage(1, scheme_named("catmull-clark")), other = moved(mesh, 5);
    RefineOptions options;
    options.rules.measure_corner_angles = true;
    const PositionRefiner refiner(mesh, "catmull-clark", 2, options);
    const StencilTable table = refine_stencils(mesh, scheme_named("catmull-clark"), 2, options).stencils;
    const std::vector<Vec3d> positions = refined_again(refiner, other).positions;
    REQUIRE(table.row_count() == static_cast<int>(positions.size()));
    double most = 0;
    for (int v = 0; v < table.row_count(); ++v) {
        Vec3d p(0);
        for (std::size_t i = 0; i < table.points(v).size(); ++i)
            p += table.weights(v)[i] * other.positions()[table.points(v)[i]];
        most = std::max(most, glm::length(p - positions[v]));
    }
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
