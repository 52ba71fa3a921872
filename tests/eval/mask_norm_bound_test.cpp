#include "../kit/corner_angle_mesh.hpp"
#include "../kit/patch_meshes.hpp"

#include "../../eval/distance/limit_samples.hpp"
#include "../../eval/estimate/mask_norm_bound.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace tetrakis;
using test::Random;

namespace {

ControlMesh random_mesh(std::uint64_t seed, bool triangles, bool with_angles = false) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 3;
    options.triangles_only = triangles;
    ControlMeshData data = test::random_mesh_data(seed, options);
    // Smooth after few levels, or never.
    const auto bounded = [](float sharpness) { return sharpness > 3 ? k_infinite_sharpness : sharpness; };
    for (auto& crease : data.creases) crease.sharpness = bounded(crease.sharpness);
    for (auto& corner : data.corners) corner.sharpness = bounded(corner.sharpness);
    if (!with_angles) return ControlMesh::build(data);
    for (std::uint32_t v = 0; v < data.positions.size(); v += 5) data.corners.push_back({v, k_infinite_sharpness});
    return test::with_mixed_angles(ControlMesh::build(data), seed);
}

/// Of limit points all over the triangle's parameters: the largest distance from it, and the largest difference,
/// parameter by parameter.
struct Sampled {
    double distance = 0, difference = 0;
};

template <class Family>
Sampled sampled(const Hierarchy& points, const CellTriangle& t) {
    constexpr int k_bits = 3, k_intervals = 1 << k_bits;
    std::vector<Site> sites;
    for (int row = 0; row <= k_intervals; ++row)
        for (int i = 0; i <= row; ++i)
            sites.push_back(detail::lattice_site_of<Family>(points.mesh(), t, k_bits, row, i));
    std::vector<Vec3d> limits(sites.size());
    points.limit_positions(sites, limits);
    const auto at = [&](int row, int i) { return limits[static_cast<std::size_t>(row * (row + 1) / 2 + i)]; };
    const Vec3d a = at(k_intervals, 0), b = at(k_intervals, k_intervals), c = at(0, 0);
    Sampled most;
    for (int row = 0; row <= k_intervals; ++row)
        for (int i = 0; i <= row; ++i) {
            const Vec3d flat =
                (double(row - i) * a + double(i) * b + double(k_intervals - row) * c) / double(k_intervals);
            most.difference = std::max(most.difference, glm::length(at(row, i) - flat));
            most.distance =
                std::max(most.distance, std::sqrt(detail::nearest_on_triangle(at(row, i), a, b, c).squared_distance));
        }
    return most;
}

double tight_bound(const SurfaceBound& bound, const CellTriangle& triangle) {
    double error = 0;
    bound.bound(std::span(&triangle, 1), 0.0, std::span(&error, 1));
    return error;
}

template <class Family>
void check_bounds(const SchemeInfo& scheme, const RuleOptions& rules, std::uint64_t seed, bool with_angles = false) {
    constexpr int k_triangles = 16;
    CAPTURE(scheme.name);
    CAPTURE(seed);
    const ControlMesh mesh = random_mesh(seed, std::is_same_v<Family, LoopFamily>, with_angles);
    REQUIRE(MaskNormBound<Family>::has(scheme, rules, mesh));
    const Hierarchy points = make_hierarchy(mesh, scheme, {.rules = rules});
    Random random(seed);
    const double aim = 0.004 * mesh.bounding_box().diagonal();
    const MaskNormBound<Family> deciding(points, scheme, rules, aim);
    std::vector<CellTriangle> triangles;
    for (int i = 0; i < k_triangles; ++i) triangles.push_back(test::random_leaf<Family>(random, mesh, 2));
    std::vector<double> decided(triangles.size());
    deciding.estimate(triangles, decided);
    int within = 0;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        CAPTURE(i);
        const Sampled found = sampled<Family>(points, triangles[i]);
        const double largest = tight_bound(deciding, triangles[i]);
        CHECK(found.distance <= largest);
        // Tight where it is above the aim; the samples may miss a little.
        CHECK(largest <= std::max(aim, 1.2 * found.difference) * (1 + 1e-9));
        CHECK((decided[i] <= aim) == (largest <= aim));
        if (decided[i] <= aim)
            CHECK(found.distance <= decided[i]);
        else
            CHECK(decided[i] <= largest * (1 + 1e-9));
        within += decided[i] <= aim ? 1 : 0;
    }
    INFO(within << " within");
    CHECK(within < k_triangles);
}

}  // namespace

TEST_CASE("[inv9] mask norms bound the difference of limit points from triangles, whatever is around them") {
    for (const char* name : {"modified-butterfly", "loop"}) check_bounds<LoopFamily>(*find_scheme(name), {}, 0);
    for (const char* name : {"kobbelt", "catmull-clark"}) check_bounds<QuadFamily>(*find_scheme(name), {}, 0);
}

TEST_CASE("[slow] [inv9] mask norms bound the difference of limit points from triangles: further schemes and rules") {
    for (const char* name : {"butterfly", "tuned-loop"}) check_bounds<LoopFamily>(*find_scheme(name), {}, 0);
    check_bounds<QuadFamily>(*find_scheme("4-8"), {}, 0);
    for (const std::uint64_t seed : test::seeds(2)) {
        if (seed == 0) continue;  // above
        for (const char* name : {"butterfly", "modified-butterfly", "tuned-loop", "loop"})
            check_bounds<LoopFamily>(*find_scheme(name), {}, seed);
        for (const char* name : {"kobbelt", "catmull-clark", "4-8"})
            check_bounds<QuadFamily>(*find_scheme(name), {}, seed);
    }
    const RuleOptions cosine{.edge_beside_crease = EdgeBesideCrease::cosine,
                             .hoppe_crease = true,
                             .reflect_at_boundary = true,
                             .butterfly_w = 0.02};
    for (const char* name : {"modified-butterfly", "loop"}) check_bounds<LoopFamily>(*find_scheme(name), cosine, 7);
    check_bounds<QuadFamily>(*find_scheme("catmull-clark"), cosine, 7);
    check_bounds<QuadFamily>(*find_scheme("averaging"), {.averaging_steps = 2}, 7);
}

TEST_CASE("[slow] [inv9] mask norms bound the difference around corners with angles of their own") {
    for (const std::uint64_t seed : {1, 2}) {
        check_bounds<LoopFamily>(*find_scheme("loop"), {}, seed, true);
        check_bounds<QuadFamily>(*find_scheme("catmull-clark"), {}, seed, true);
    }
}

TEST_CASE("[slow] [inv9] mask norms of more averaging bound the difference, too") {
    check_bounds<QuadFamily>(*find_scheme("averaging"), {.averaging_steps = 4}, 7);
}

TEST_CASE("[inv9] mask norms bound the smallest triangles, too") {
    const ControlMesh mesh = random_mesh(5, true);
    const SchemeInfo& scheme = *find_scheme("modified-butterfly");
    const Hierarchy points = make_hierarchy(mesh, scheme);
    const RuleOptions rules;
    const MaskNormBound<LoopFamily> bound(points, scheme, rules, 0);
    for (const int level : {12, 19, 20, 24}) {
        CAPTURE(level);
        // Beside a control vertex the surface is bent at every level.
        for (std::uint32_t f = 0; f < 4; ++f) {
            const CellTriangle t{
                mesh.face_halfedge(FaceId(f)), static_cast<std::uint8_t>(level), {LatticePoint{0, 0}, {1, 0}, {0, 1}}};
            const double found = sampled<LoopFamily>(points, t).distance, largest = tight_bound(bound, t);
            CHECK(found <= largest);
            CHECK(largest > 0);
        }
    }
}

TEST_CASE("[slow] [inv9] averaging is tessellated to a certified tolerance where that is asked for") {
    const ControlMesh mesh = ControlMesh::build(test::skewed_grid(2));
    TessellateOptions options{.scheme = *find_scheme("averaging"),
                              .rules = {.averaging_steps = 2},
                              .estimator = EstimatorKind::certified,
                              .tolerance = 0.01,
                              .measure = true,
                              .measure_samples = 10'000};
    const Tessellation sure = tessellate(mesh, options);
    REQUIRE(sure.certified_error);
    CHECK(*sure.certified_error <= sure.tolerance_absolute * (1 + 1e-9));
    CHECK(sure.measured_error->hausdorff <= *sure.certified_error * (1 + 1e-9));
    options.estimator = EstimatorKind::measured;
    CHECK_FALSE(tessellate(mesh, options).certified_error);
    options.rules.averaging_steps = 3;
    options.estimator = EstimatorKind::certified;
    CHECK_THROWS_AS(tessellate(mesh, options), Error);
}

TEST_CASE("[bad-input] tags that stay semi-sharp for long have no bound by mask norms") {
    const auto tagged = [](const std::string& sharpness) {
        return ControlMesh::build(
            parse_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
                      "t crease 2/1/0 0 1 " +
                          sharpness + "\n",
                      "test.obj"));
    };
    const SchemeInfo& scheme = *find_scheme("modified-butterfly");
    const ControlMesh some = tagged("2.5"), many = tagged("7.5");
    const auto result = [&](const ControlMesh& mesh, EstimatorKind estimator) {
        return tessellate(
            mesh,
            {.scheme = scheme, .estimator = estimator, .tolerance = 0.05, .measure = true, .measure_samples = 10'000});
    };
    const Tessellation sure = result(some, EstimatorKind::certified);
    REQUIRE(sure.certified_error);
    CHECK(*sure.certified_error <= sure.tolerance_absolute * (1 + 1e-9));
    CHECK(sure.measured_error->hausdorff <= *sure.certified_error);
    CHECK_FALSE(MaskNormBound<LoopFamily>::has(scheme, {}, many));
    CHECK_FALSE(result(many, EstimatorKind::measured).certified_error);
    CHECK_THROWS_WITH_AS(result(many, EstimatorKind::certified), doctest::Contains("semi-sharp"), Error);
}
