#include "../kit/corner_angle_mesh.hpp"
#include "../kit/hierarchy_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/nearest.hpp"
#include "../kit/scheme_meshes.hpp"
#include "../kit/surface_topology.hpp"

#include "../../eval/distance/hausdorff.hpp"
#include "../../eval/patches/quad_patches.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/attributes/uv_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::k_closed;
using test::mesh_for;
using test::triangles_of;

namespace {

// Of a measurement: fewer than by default, for time; triangles and edges have their own, and the worst ones climb.
constexpr std::uint64_t k_samples = 20'000;

/// An open patch of two quads, a triangle and a pentagon around one vertex, not flat.
const char* const k_open =
    "v 0 0 0\nv 1 0 0.2\nv 2 0 0\nv 2.3 1 0.5\nv 1.2 1 0.9\nv 0 1 0.3\nv 1.7 2 0.2\nv 0.5 2 0\nv -0.7 1.6 -0.3\n"
    "f 1 2 5 6\nf 2 3 4 5\nf 5 4 7\nf 6 5 7 8 9\n";

/// Closed: two pentagons that share two edges, between which only they meet (vertex 9), and four quads.
const char* const k_pillow =
    "v 0 0 0\nv 2 0 0.3\nv 2 2 0\nv 0 2 0.2\nv 1 0 1\nv 1 2 1.2\nv 1 0 -0.8\nv 1 2 -1\nv 0.5 1 0.9\n"
    "f 1 5 9 6 4\nf 5 2 3 6 9\nf 1 4 8 7\nf 7 8 3 2\nf 1 7 2 5\nf 4 6 3 8\n";

template <class Call>
std::string refusal(ErrorCode code, Call&& call) {
    const Error error = test::error_of(call);
    CHECK(error.code() == code);
    return error.what();
}

/// A grid over [0, 4]^2, all flat but for one vertex, in two charts that are linear in x and y.
ControlMeshData grid_of_two_charts() {
    ControlMeshData data = test::grid(4);
    data.positions[11].z = 1;
    for (const double shift : {0.0, 0.5})
        for (const Vec3d& p : data.positions) data.uvs.emplace_back(0.1 * p.x + shift, 0.2 * p.y);
    for (std::size_t c = 0; c < data.face_vertices.size(); ++c)
        data.face_uvs.push_back(data.face_vertices[c] + (c / 4 % 4 < 2 ? 0 : 25));
    return data;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("dual schemes tessellate meshes with inner vertices of two faces by whole levels") {
    for (const char* name : {"doo-sabin", "midedge", "biquartic"}) {
        CAPTURE(name);
        const ControlMesh mesh = mesh_for(*find_scheme(name), k_pillow);
        const Tessellation result = tessellate(mesh, {.scheme = name, .tolerance = 2e-2});
        CHECK(result.tolerance_reached);
        CHECK(test::topology(result.mesh.triangles) == test::surface_topology(mesh));
        REQUIRE(result.warnings.size() == 1);
        CHECK(test::contains(result.warnings[0], "two faces"));
    }
}

TEST_CASE("limit normals come by rows where a crease's ends have no tangent plane, without levels that are too large") {
    const SchemeInfo& scheme = *find_scheme("butterfly");
    const ControlMesh mesh = mesh_for(scheme, test::k_closed + std::string("t crease 2/1/0 4 8 10\n"));
    RunContext context;
    context.max_memory_bytes = std::uint64_t{24} << 20;
    const Tessellation result = tessellate(
        mesh, {.scheme = scheme, .rules = {.butterfly_w = 0.02}, .tolerance = 1e-2, .measure = false}, context);
    CHECK(result.tolerance_reached);
    CHECK(result.warnings.empty());
    for (const Vec3d& normal : result.mesh.normals) CHECK(glm::length(normal) == doctest::Approx(1));
}

TEST_CASE("semi-sharp creases of dual schemes are sharp for ever, by rows that repeat themselves, and that is said") {
    const auto creased = [](const char* sharpness) {
        std::string text = k_closed;
        for (const char* edge : {"4 8", "8 7", "8 5"})
            text += std::string("t crease 2/1/0 ") + edge + " " + sharpness + "\n";
        return text + "t corner 1/1/0 8 " + sharpness + "\n";
    };
    for (const char* name : {"doo-sabin", "midedge"}) {
        CAPTURE(name);
        const SchemeInfo& scheme = *find_scheme(name);
        const Tessellation sharp = tessellate(mesh_for(scheme, creased("10")), {.scheme = name, .tolerance = 1e-2}),
                           semi = tessellate(mesh_for(scheme, creased("0.7")), {.scheme = name, .tolerance = 1e-2});
        CHECK(semi.mesh.triangles == sharp.mesh.triangles);
        // Whole levels by the rules would have other last bits.
        CHECK(semi.mesh.positions == sharp.mesh.positions);
        CHECK(sharp.warnings.empty());
        REQUIRE(semi.warnings.size() == 1);
        CHECK(test::contains(semi.warnings[0], "sharp for ever"));
    }
    const Tessellation ignored =
        tessellate(mesh_for(*find_scheme("biquartic"), creased("10")), {.scheme = "biquartic", .tolerance = 2e-2});
    REQUIRE(ignored.warnings.size() == 1);
    CHECK(test::contains(ignored.warnings[0], "creases were ignored"));
    // Hexagons' semi-sharp creases do run out.
    CHECK(refine(mesh_for(*find_scheme("honeycomb"), creased("0.7")), "honeycomb", 1).warnings.empty());
}

TEST_CASE("[slow] dual schemes tessellate meshes with holes: what is left is refined to the tolerance, too") {
    const std::string text = std::string(k_open) + "v 3 1.6 0.4\nv 2.6 2.4 0.9\nf 4 10 11 7\nt hole 1/0/0 1\n";
    for (const char* name : {"doo-sabin", "midedge", "biquartic"}) {
        CAPTURE(name);
        const SchemeInfo& scheme = *find_scheme(name);
        const ControlMesh mesh = mesh_for(scheme, text);
        const Tessellation result =
            tessellate(mesh, {.scheme = scheme, .tolerance = 1e-2, .measure = true, .measure_samples = k_samples});
        CHECK(result.tolerance_reached);
        CHECK(result.mesh.triangles.size() < 4'000);
        CHECK(test::topology(result.mesh.triangles) == test::surface_topology(mesh));
        CHECK(std::count(result.triangle_face.begin(), result.triangle_face.end(), 1u) == 0);
        // The edges of holes are edges of no level: each comes nearer to them.
        const TriangleMesh reference = triangles_of(refine(mesh, scheme, 6, {.limit = true}));
        const MeasuredError error = compare(reference, result.mesh, {.samples = 30'000}).error;
        CHECK(error.hausdorff <= 1.5 * result.tolerance_absolute);
    }
}

TEST_CASE("[slow] averages whose boundary recedes are tessellated by whole levels, with a warning") {
    for (const int steps : {1, 2}) {
        CAPTURE(steps);
        ControlMeshData data = test::grid(3u * static_cast<std::uint32_t>(steps));
        for (Vec3d& p : data.positions) p.z = static_cast<int>(p.x * p.y) % 3;
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        TessellateOptions options{.scheme = "averaging", .tolerance = 2e-2, .measure_samples = k_samples};
        options.rules.averaging_boundary = AveragingBoundary::recede;
        options.rules.averaging_steps = steps;
        options.measure = true;
        const Tessellation result = tessellate(mesh, options);
        CHECK(result.tolerance_reached);
        REQUIRE(!result.warnings.empty());
        CHECK(test::contains(result.warnings[0], "whole levels"));
        options.estimator = EstimatorKind::certified;
        CHECK(test::contains(refusal(ErrorCode::unsupported, [&] { tessellate(mesh, options); }), "certified"));
    }
}

TEST_CASE("Catmull-Clark and Loop by other than their plain rules go by limit points, too") {
    const ControlMesh mesh = mesh_for(*find_scheme("loop"), k_closed);
    const Tessellation warren = tessellate(mesh, {.scheme = "loop",
                                                  .rules = {.loop_weights = LoopWeights::warren},
                                                  .tolerance = 1e-2,
                                                  .measure = true,
                                                  .measure_samples = k_samples});
    CHECK(warren.tolerance_reached);
    // By plain rules both ways agree.
    const Tessellation patches = tessellate(mesh, {.scheme = "loop", .tolerance = 1e-2, .measure = false});
    const Tessellation points =
        tessellate(mesh, {.scheme = "tuned-loop", .rules = {.tuning = 0}, .tolerance = 1e-2, .measure = false});
    CHECK(patches.certified_error);
    const double apart = compare(patches.mesh, points.mesh, {.samples = 20'000}).error.hausdorff;
    CHECK(apart <= 2 * patches.tolerance_absolute);
    const double ratio =
        static_cast<double>(points.mesh.triangles.size()) / static_cast<double>(patches.mesh.triangles.size());
    CHECK(ratio > 0.8);
    CHECK(ratio < 1.25);
}

TEST_CASE("levels are kept: at least so many, at most so many") {
    for (const std::string name : {"kobbelt", "butterfly", "midedge", "sqrt3"}) {
        CAPTURE(name);
        const SchemeInfo& scheme = *find_scheme(name);
        const ControlMesh mesh = mesh_for(scheme, k_open);
        const Tessellation least =
            tessellate(mesh, {.scheme = scheme, .tolerance = 0.5, .min_level = 2, .measure = false});
        const Tessellation free = tessellate(mesh, {.scheme = scheme, .tolerance = 0.5, .measure = false});
        CHECK(least.deepest_level == 2);
        CHECK(free.deepest_level < 2);
        CHECK(least.mesh.triangles.size() > 3 * free.mesh.triangles.size());
        const Tessellation most =
            tessellate(mesh, {.scheme = scheme, .tolerance = 1e-4, .max_level = 2, .measure = false});
        CHECK(!most.tolerance_reached);
        CHECK(most.deepest_level == 2);
    }
}

TEST_CASE("[inv9] linear schemes: certified by their polynomials, and coarse where the control mesh is flat") {
    const ControlMesh cube = mesh_for(*find_scheme("bilinear"),
                                      "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\n"
                                      "v 1 1 1\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 4 3 7 8\nf 3 1 5 7\nf 2 4 8 6\n");
    for (const EstimatorKind estimator : {EstimatorKind::measured, EstimatorKind::certified}) {
        const Tessellation flat = tessellate(cube, {.scheme = "bilinear",
                                                    .estimator = estimator,
                                                    .tolerance = 1e-3,
                                                    .measure = true,
                                                    .measure_samples = k_samples});
        CHECK(flat.mesh.triangles.size() == 12);
        CHECK(*flat.certified_error < 1e-11);
        const ControlMesh triangles = mesh_for(*find_scheme("midpoint"), k_open);
        const Tessellation same = tessellate(triangles, {.scheme = "midpoint",
                                                         .estimator = estimator,
                                                         .tolerance = 1e-3,
                                                         .measure = true,
                                                         .measure_samples = k_samples});
        CHECK(same.mesh.triangles.size() == triangles.face_count());
        CHECK(same.measured_error->hausdorff <= *same.certified_error);
        CHECK(*same.certified_error < 1e-11);

        const ControlMesh open = mesh_for(*find_scheme("bilinear"), k_open);
        const Tessellation bent = tessellate(open, {.scheme = "bilinear",
                                                    .estimator = estimator,
                                                    .tolerance = 2e-3,
                                                    .measure = true,
                                                    .measure_samples = k_samples});
        CHECK(bent.measured_error->hausdorff <= *bent.certified_error);
        CHECK(bent.measured_error->hausdorff > 0.1 * *bent.certified_error);
        if (estimator == EstimatorKind::certified) CHECK(*bent.certified_error <= bent.tolerance_absolute);
        CHECK(bent.tolerance_reached);
    }
}

TEST_CASE("texture coordinates follow a scheme, seams included") {
    // Rules of linear precision leave the charts linear.
    const auto mesh_with = [](const SchemeInfo& scheme, std::vector<ControlMeshData::EdgeTag> creases) {
        ControlMeshData data = grid_of_two_charts();
        data.creases = std::move(creases);
        return mesh_for(scheme, ControlMesh::build(std::move(data)));
    };
    for (const char* name :
         {"kobbelt", "bilinear", "midpoint", "doo-sabin", "doo-sabin-cc", "midedge", "midedge-simplest", "biquartic"}) {
        CAPTURE(name);
        const SchemeInfo& scheme = *find_scheme(name);
        const bool dual = scheme.lattice == FanLattice::dual;
        const Tessellation result = tessellate(
            mesh_with(scheme, {}),
            {.scheme = scheme, .tolerance = dual ? 1e-3 : 1e-2, .min_level = dual ? 0 : 2, .measure = false});
        CHECK(result.warnings.empty());
        CHECK(result.deepest_level >= 2);
        REQUIRE(result.mesh.triangle_uvs.size() == result.mesh.triangles.size());
        double off = 0;
        int wrong = 0;
        for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t) {
            // A triangle of a dual scheme across the seam has the UVs of one side, all its corners.
            double centre = 0, off_first = 0, off_second = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3d p = result.mesh.positions[result.mesh.triangles[t][k]];
                const Vec2d uv = result.mesh.uvs[result.mesh.triangle_uvs[t][k]];
                centre += p.x / 3;
                off_first = std::max(off_first, glm::length(uv - Vec2d(0.1 * p.x, 0.2 * p.y)));
                off_second = std::max(off_second, glm::length(uv - Vec2d(0.1 * p.x + 0.5, 0.2 * p.y)));
            }
            off = std::max(off, std::min(off_first, off_second));
            const double across = dual ? 0.5 : 0;
            wrong += centre < 2 - across ? off_first > 0.1 : centre > 2 + across && off_second > 0.1;
        }
        CHECK(off < 1e-10);
        CHECK(wrong == 0);
    }
    // A seam along a crease that ends inside has no charts to go on with; semi-sharp creases are sharp for ever.
    const SchemeInfo& scheme = *find_scheme("doo-sabin");
    CHECK(!tessellate(mesh_with(scheme, {{6, 7, 2}}), {.scheme = scheme, .tolerance = 1e-2}).mesh.uvs.empty());
    for (const float sharpness : {k_infinite_sharpness, 2.0f}) {
        const Tessellation along = tessellate(mesh_with(scheme, {{2, 7, sharpness}, {7, 12, sharpness}}),
                                              {.scheme = scheme, .tolerance = 1e-2, .measure = false});
        CHECK(along.mesh.uvs.empty());
        REQUIRE(along.warnings.size() == (sharpness < k_infinite_sharpness ? 2 : 1));
        CHECK(test::contains(along.warnings.back(), "texture"));
    }
}

namespace {

/// Random triangles with tags and holes, in two charts that meet along a jagged seam, and two materials.
ControlMesh with_charts(const ControlMesh& mesh, FaceVaryingRule rule) {
    ControlMeshData data = mesh.data();
    for (const Vec3d& p : data.positions)
        for (const double shift : {0.0, 10.0}) data.uvs.emplace_back(p.x + 0.3 * p.z + shift, p.y - 0.2 * p.z);
    const double middle = mesh.bounding_box().centre().x;
    data.materials = {"left", "right"};
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
        Vec3d centre(0);
        for (std::uint32_t k = 0; k < 3; ++k) centre += data.positions[data.face_vertices[3 * f + k]] / 3.0;
        data.face_material.push_back(centre.y > mesh.bounding_box().centre().y ? 1 : 0);
        for (std::uint32_t k = 0; k < 3; ++k)
            data.face_uvs.push_back(2 * data.face_vertices[3 * f + k] + (centre.x < middle ? 0 : 1));
    }
    data.face_varying_rule = rule;
    return ControlMesh::build(std::move(data));
}

/// A point for a triangle's corner, which other UVs or materials move.
Vec3d corner_mark(const Vec3d& point, const Vec2d& uv, std::uint32_t material) {
    return point + 3.7 * Vec3d(uv, material);
}

/// Those of a level of uniform refinement, on the limit; the charts' limits from their own refinement, which shares the
/// level's numbers.
std::vector<Vec3d> uniform_corners(const ControlMesh& mesh, int level) {
    const PolygonMesh surface = refine(mesh, "sqrt3", level, {.limit = true});
    const bool linear = mesh.face_varying_rule() == FaceVaryingRule::linear_all;
    const ControlMesh charts = uv_mesh(mesh);
    const PolygonMesh net = refine(charts, "sqrt3", level), on_limit = refine(charts, "sqrt3", level, {.limit = true});
    const PointMatch match(net.positions);
    std::vector<Vec3d> result;
    for (std::uint32_t c = 0; c < surface.face_uvs.size(); ++c) {
        const Vec2d uv = surface.uvs[surface.face_uvs[c]];
        result.push_back(corner_mark(surface.positions[surface.face_vertices[c]],
                                     linear ? uv : Vec2d(on_limit.positions[match.nearest(Vec3d(uv, 0))]),
                                     surface.face_material[c / 3]));
    }
    return result;
}

}  // namespace

TEST_CASE("[slow] [inv1] sqrt3: texture coordinates and materials are those of uniform refinement, seams included") {
    for (const std::uint64_t seed : {0, 1, 2, 5, 8}) {
        for (const FaceVaryingRule rule :
             {FaceVaryingRule::corners_only, FaceVaryingRule::boundaries, FaceVaryingRule::linear_all}) {
            CAPTURE(seed);
            CAPTURE(static_cast<int>(rule));
            const ControlMesh mesh = with_charts(test::random_sqrt3_mesh(seed), rule);
            const double size = mesh.bounding_box().diagonal();
            const std::vector<Vec3d> uniform = uniform_corners(mesh, 2);
            const PointMatch match(uniform);
            const auto missing = [&](const Tessellation& result) {
                std::size_t count = 0;
                const TriangleMesh& m = result.mesh;
                REQUIRE(m.triangle_uvs.size() == m.triangles.size());
                for (std::size_t t = 0; t < m.triangles.size(); ++t)
                    for (std::size_t k = 0; k < 3; ++k) {
                        const Vec3d mark = corner_mark(m.positions[m.triangles[t][k]], m.uvs[m.triangle_uvs[t][k]],
                                                       m.triangle_material[t]);
                        count += glm::length(uniform[match.nearest(mark)] - mark) > 1e-9 * size;
                    }
                return count;
            };
            const Tessellation all = tessellate(
                mesh, {.scheme = "sqrt3", .tolerance = 10, .min_level = 2, .max_level = 2, .measure = false});
            CHECK(3 * all.mesh.triangles.size() == uniform.size());
            CHECK(missing(all) == 0);
            CHECK(all.warnings.empty());
            // Leaves of all levels up to the same.
            const Tessellation some =
                tessellate(mesh, {.scheme = "sqrt3", .tolerance = 1e-2, .max_level = 2, .measure = false});
            CHECK(some.mesh.triangles.size() < all.mesh.triangles.size());
            CHECK(some.mesh.triangles.size() > mesh.face_count());
            CHECK(missing(some) == 0);
            CHECK(test::topology(some.mesh.triangles) == test::surface_topology(mesh));
            const Tessellation without = tessellate(
                mesh, {.scheme = "sqrt3", .tolerance = 1e-2, .max_level = 2, .uvs = false, .measure = false});
            CHECK(without.mesh.uvs.empty());
        }
    }
}

TEST_CASE("[slow] honeycomb refinement is tessellated by whole levels") {
    ControlMeshData data = parse_obj(
        "v 0 0 0\nv 1 0 0.2\nv 2 0 0\nv 2.3 1 0.5\nv 1.2 1 0.9\nv 0 1 0.3\nv 1.7 2 0.2\nvt 0 0\nvt 1 0\nvt 2 0\nvt 2 "
        "1\n"
        "vt 1 1\nvt 0 1\nvt 1 2\nusemtl a\nf 1/1 2/2 5/5 6/6\nusemtl b\nf 2/2 3/3 4/4 5/5\nf 5/5 4/4 7/7\n",
        "test.obj");
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    int before = 0;
    for (const double tolerance : {0.05, 0.01}) {
        CAPTURE(tolerance);
        const Tessellation result = tessellate(
            mesh, {.scheme = "honeycomb", .tolerance = tolerance, .measure = true, .measure_samples = 20'000});
        CHECK(result.tolerance_reached);
        REQUIRE(result.measured_error);
        CHECK(result.measured_error->hausdorff <= result.tolerance_absolute);
        CHECK(result.deepest_level >= before);
        before = result.deepest_level;
        CHECK(result.mesh.triangle_uvs.size() == result.mesh.triangles.size());
        // Vertices are those of the level's limit.
        const PolygonMesh level = refine(mesh, "honeycomb", result.deepest_level, {.limit = true});
        CHECK(result.mesh.positions == level.positions);
    }
    CHECK(before > 1);
    // The level before does not do.
    const Tessellation coarser = tessellate(mesh, {.scheme = "honeycomb",
                                                   .tolerance = 0.01,
                                                   .max_level = before - 1,
                                                   .measure = true,
                                                   .measure_samples = 20'000});
    CHECK_FALSE(coarser.tolerance_reached);
    CHECK(coarser.measured_error->hausdorff > coarser.tolerance_absolute);
    TessellateOptions within;
    within.scheme = "honeycomb";
    within.max_triangles = 200;
    within.measure = false;
    const Tessellation few = tessellate(mesh, within);
    CHECK(few.mesh.triangles.size() <= 200);
    CHECK(few.mesh.triangles.size() > 40);
    CHECK_FALSE(few.measured_error);
}

TEST_CASE("honeycomb refinement of a pillow: no diagonal of a face joins vertices that another one joins") {
    const ControlMesh mesh =
        ControlMesh::build(parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0.3\nv 0 1 0\nf 1 2 3 4\nf 4 3 2 1\n", "test.obj"));
    for (const double tolerance : {0.5, 0.02}) {
        CAPTURE(tolerance);
        const Tessellation result = tessellate(mesh, {.scheme = "honeycomb", .tolerance = tolerance});
        CHECK(test::topology(result.mesh.triangles) == test::surface_topology(mesh));
    }
}

TEST_CASE("honeycomb refinement with holes: faces that touch in a vertex alone are tessellated") {
    const ControlMesh mesh = ControlMesh::build(
        parse_obj("v -0.29 -0.26 0.15\nv 1.2 -0.27 0.18\nv 1.9 0.16 0.33\nv 2.9 0.12 0.59\nv 0.085 1.2 -0.54\n"
                  "v 1.1 0.9 -0.59\nv 1.7 1.1 0.19\nv 3.1 1 -0.32\nv 0.19 1.9 0.26\nv 1.1 1.9 -0.14\n"
                  "v 1.8 1.7 -0.56\nv 3.2 2.2 -0.48\nv -0.079 2.8 -0.44\nv 0.83 2.7 0.57\nv 2.3 3 -0.47\n"
                  "v 3 3 -0.55\n"
                  "f 1 2 6 5\nf 13 9 10 14\nf 8 12 11 7\nf 9 5 6 10\nf 11 12 16 15\nf 15 14 10 11\nf 3 4 8 7 6 2\n"
                  "t hole 1/0/0 0\nt hole 1/0/0 5\nt crease 2/1/0 5 6 1.25\nt crease 2/1/0 9 13 4\nt "
                  "interpolateboundary 1/0/0 1\n",
                  "test.obj"));
    const Tessellation result = tessellate(
        mesh,
        {.scheme = "honeycomb", .tolerance = 0.05, .crease_degrees = 180, .measure = true, .measure_samples = 10'000});
    CHECK(result.tolerance_reached);
    const PolygonMesh level = refine(mesh, "honeycomb", result.deepest_level, {.limit = true, .normals = true});
    CHECK(result.mesh.positions == level.positions);
    CHECK(result.mesh.normals == level.normals);
    CHECK(test::topology(result.mesh.triangles) == test::topology(test::faces_of(level)));
    // So they do: a vertex of two fans.
    ControlMeshData data;
    data.positions = level.positions;
    data.face_offsets = level.face_offsets;
    data.face_vertices = level.face_vertices;
    CHECK_THROWS_WITH_AS(ControlMesh::build(std::move(data)), doctest::Contains("not one fan"), Error);
}

TEST_CASE("[bad-input] what a scheme cannot do is refused, with what to use instead") {
    const ControlMesh mesh = mesh_for(*find_scheme("kobbelt"), k_closed);
    const auto code = ErrorCode::unsupported;
    const std::string uncertified = refusal(code, [&] {
        tessellate(mesh, {.scheme = "biquartic", .estimator = EstimatorKind::certified, .tolerance = 1e-2});
    });
    CHECK(test::contains(uncertified, "measured estimator"));
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        if (scheme_support(scheme.name).certified) CHECK(test::contains(uncertified, scheme.name.data()));
    }
    const TriangleMesh target = triangles_of(refine(mesh, "kobbelt", 1));
    CHECK(test::contains(
        refusal(code, [&] { tessellate(mesh, {.scheme = "kobbelt", .tolerance = 1e-2, .target = &target}); }),
        "catmull-clark or loop"));
    // Corners with angles have no patches.
    const ControlMesh plain = test::sheet(false), angles = test::with_mixed_angles(plain, 3);
    CHECK(scheme_support(plain, SchemeKind::catmull_clark).patches);
    CHECK(!scheme_support(angles, SchemeKind::catmull_clark).patches);
    CHECK(scheme_support(angles, SchemeKind::catmull_clark).certified);
    CHECK(test::contains(refusal(code, [&] { QuadPatches{angles}; }), "corner angles"));
    CHECK(test::contains(refusal(code, [&] { tessellate(angles, {.tolerance = 1e-2, .target = &target}); }),
                         "corner angles"));
    CHECK(test::contains(
        refusal(ErrorCode::invalid_input, [&] { tessellate(mesh, {.scheme = "buterfly", .tolerance = 1e-2}); }),
        "did you mean butterfly?"));
    CHECK(test::contains(
        refusal(ErrorCode::invalid_input, [&] { tessellate(mesh, {.scheme = "butterfly", .tolerance = 1e-2}); }),
        "triangulate()"));
    CHECK(test::contains(
        refusal(ErrorCode::invalid_input, [&] { tessellate(mesh, {.scheme = "kobbelt", .tolerance = 1e-18}); }),
        "rounding"));
    // What certified dual schemes do not know.
    const ControlMesh hole = mesh_for(*find_scheme("doo-sabin"), std::string(k_closed) + "t hole 1/0/0 0\n");
    const auto certified = [&](const ControlMesh& control, const RuleOptions& rules, const char* scheme) {
        return refusal(code, [&] {
            tessellate(control,
                       {.scheme = scheme, .rules = rules, .estimator = EstimatorKind::certified, .tolerance = 1e-2});
        });
    };
    CHECK(test::contains(certified(hole, {}, "doo-sabin"), "holes"));
    CHECK(test::contains(certified(mesh_for(*find_scheme("midedge"), k_pillow), {}, "midedge"), "two faces"));
    const Tessellation open = tessellate(hole, {.scheme = "kobbelt", .tolerance = 1e-2, .measure = false});
    CHECK(test::topology(open.mesh.triangles) == test::surface_topology(hole));
}

TEST_SUITE_END();
