#include "../../eval/tessellate/tessellate.hpp"

#include "judge.hpp"

#include "../kit/hierarchy_helpers.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/scheme_meshes.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/obj/obj_reader.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <set>
#include <string>

using namespace tetrakis;
using contract::LimitJudge;
using EstimatorKind::certified;
using EstimatorKind::measured;
using test::k_closed;
using test::k_tube;
using test::mesh_for;
using test::same_bytes;

namespace {

constexpr double k_rounding = 1 + 1e-9;
constexpr std::uint64_t k_samples = 8'000;

const char* const k_schemes[] = {"catmull-clark", "loop",  "doo-sabin", "midedge",    "4-8",      "kobbelt",
                                 "butterfly",     "sqrt3", "biquartic", "tuned-loop", "bilinear", "honeycomb"};

bool is_dual(const SchemeInfo& scheme) { return scheme.refinement == Refinement::vertex_split; }

/// A random mesh without tags. Only its boundary is sharp.
ControlMeshData smooth_mesh(std::uint64_t seed, const SchemeInfo& scheme) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 3;
    options.crease = options.corner = options.hole = options.edge_vertices = 0;
    options.boundary_rule = BoundaryRule::edge_and_corner;
    options.triangles_only = scheme.family == MeshFamily::triangles;
    return test::random_mesh_data(seed, options);
}

double diagonal(const ControlMesh& mesh) { return mesh.bounding_box().diagonal(); }

void check_watertight(const ControlMesh& mesh, const Tessellation& result) {
    CHECK(test::topology(result.mesh.triangles) == test::surface_topology(mesh));
}

/// Checks that vertices are limit points of refine() at levels up to the deepest + 1, without tags also their normals.
void check_vertices(const ControlMesh& mesh, const SchemeInfo& scheme, const Tessellation& result) {
    const PolygonMesh limits =
        test::limits_of(mesh, scheme, result.deepest_level + 1, {.normals = scheme.smoothness != "C0"});
    const PointMatch match(limits.positions), corners(mesh.positions());
    const bool has_tags = !(mesh.data().creases.empty() && mesh.data().corners.empty() && mesh.data().holes.empty());
    const bool has_normals = !limits.normals.empty() && !has_tags && scheme_support(scheme).adaptive;
    // At boundaries sqrt3 has no tangent masks: normals are averages of faces on some level.
    const double least = scheme.refinement == Refinement::sqrt3 && mesh.has_boundary() ? 0.8 : 1 - 1e-6;
    const double near = 1e-10 * diagonal(mesh);
    double off = 0;
    std::size_t turned = 0;
    for (std::size_t v = 0; v < result.mesh.positions.size(); ++v) {
        const Vec3d& p = result.mesh.positions[v];
        const std::uint32_t i = match.nearest(p);
        off = std::max(off, glm::length(limits.positions[i] - p));
        // Corners have no tangent plane, so no unique normal.
        if (!has_normals || glm::length(mesh.position(VertexId(corners.nearest(p))) - p) < near) continue;
        turned += !(glm::dot(limits.normals[i], result.mesh.normals[v]) > least);
    }
    CHECK(off <= near);
    CHECK(turned == 0);
}

/// Compares the distances that the result reports with those of an independent judge.
void check_distance(const ControlMesh& mesh, const SchemeInfo& scheme, const Tessellation& result, bool by_bound) {
    const LimitJudge judge(mesh, scheme, contract::judging_level(mesh, scheme, result));
    const double forward = judge.limit_to_mesh(result.mesh), backward = judge.mesh_to_limit(result.mesh);
    CAPTURE(result.tolerance_absolute);
    CAPTURE(judge.doubt());
    CHECK(judge.doubt() <= result.tolerance_absolute);
    CHECK(result.tolerance_reached);
    if (by_bound) {
        REQUIRE(result.certified_error);
        CHECK(*result.certified_error <= result.tolerance_absolute);
    } else {
        CHECK(forward <= k_rounding * result.tolerance_absolute);
        CHECK(backward <= k_rounding * result.tolerance_absolute + judge.doubt());
    }
    if (result.certified_error) {
        const double rounding = 1e-14 * diagonal(mesh);
        CHECK(forward <= k_rounding * *result.certified_error + rounding);
        CHECK(backward <= k_rounding * *result.certified_error + judge.doubt() + rounding);
        if (result.measured_error)
            CHECK(result.measured_error->hausdorff <= k_rounding * *result.certified_error + rounding);
    }
    if (result.measured_error) {
        const MeasuredError& measured = *result.measured_error;
        CHECK(measured.hausdorff == std::max(measured.forward, measured.backward));
        CHECK(measured.hausdorff <= k_rounding * result.tolerance_absolute);
        CHECK(measured.mean <= k_rounding * measured.rms);
        CHECK(measured.rms <= k_rounding * measured.hausdorff);
        // Neither measurement finds much larger distances than the other.
        CHECK(forward <= 1.1 * measured.hausdorff + judge.doubt());
        CHECK(measured.hausdorff <= 1.1 * std::max(forward, backward) + judge.doubt() + 1e-14 * diagonal(mesh));
    }
}

/// Checks all properties that every result must have, with each estimator of the scheme.
void check_all(const ControlMesh& mesh, const SchemeInfo& scheme, double tolerance, bool bound_is_known = true,
               bool few_faces = true) {
    for (const EstimatorKind estimator : {EstimatorKind::measured, EstimatorKind::certified}) {
        const bool by_bound = estimator == EstimatorKind::certified;
        if (by_bound && !(bound_is_known && scheme_support(mesh, scheme).certified)) continue;
        CAPTURE(scheme.name);
        CAPTURE(by_bound);
        const Tessellation result = tessellate(mesh, {.scheme = scheme,
                                                      .estimator = estimator,
                                                      .tolerance = tolerance,
                                                      .crease_degrees = 180,
                                                      .measure = true,
                                                      .measure_samples = k_samples});
        CHECK(result.tolerance_absolute == doctest::Approx(tolerance * diagonal(mesh)).epsilon(1e-12));
        CHECK(result.triangle_face.size() == result.mesh.triangles.size());
        CHECK(result.triangle_error.size() == result.mesh.triangles.size());
        check_watertight(mesh, result);
        if (few_faces) check_vertices(mesh, scheme, result);
        check_distance(mesh, scheme, result, by_bound);
    }
}

/// Code of the error with which tessellate() ends, if any.
std::optional<ErrorCode> code_of(const ControlMesh& mesh, const TessellateOptions& options, const RunContext& context) {
    try {
        tessellate(mesh, options, context);
    } catch (const Error& error) {
        return error.code();
    }
    return std::nullopt;
}

void check_same(const Tessellation& a, const Tessellation& b) {
    CHECK(same_bytes(a.mesh.positions, b.mesh.positions));
    CHECK(same_bytes(a.mesh.triangles, b.mesh.triangles));
    CHECK(same_bytes(a.mesh.normals, b.mesh.normals));
    CHECK(same_bytes(a.mesh.triangle_normals, b.mesh.triangle_normals));
    CHECK(same_bytes(a.mesh.uvs, b.mesh.uvs));
    CHECK(same_bytes(a.mesh.triangle_uvs, b.mesh.triangle_uvs));
    CHECK(same_bytes(a.triangle_face, b.triangle_face));
    CHECK(same_bytes(a.triangle_error, b.triangle_error));
    CHECK(a.certified_error == b.certified_error);
    REQUIRE(a.measured_error.has_value() == b.measured_error.has_value());
    if (a.measured_error) CHECK(a.measured_error->rms == b.measured_error->rms);
}

}  // namespace

TEST_SUITE_BEGIN("contract");

TEST_CASE("the judge knows distances that are known") {
    // The limit surface of bilinear refinement is the unit square itself.
    const ControlMesh square = ControlMesh::build(parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", ""));
    const LimitJudge judge(square, *find_scheme("bilinear"), 3);
    CHECK(judge.doubt() < 1e-15);
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0.25}, {1, 0, 0.25}, {1, 1, 0.25}, {0, 1, 0.25}, {0.5, 0.5, 1}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    CHECK(judge.limit_to_mesh(mesh) == doctest::Approx(0.25));
    CHECK(judge.mesh_to_limit(mesh) == doctest::Approx(0.25));
    mesh.triangles = {{0, 1, 2}};  // half of the square: the far corner is half a diagonal away
    CHECK(judge.limit_to_mesh(mesh) == doctest::Approx(std::sqrt(0.5 + 0.0625)));
    mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};  // a flap
    CHECK(judge.mesh_to_limit(mesh) == doctest::Approx(1));
    // A mesh that is too coarse for the tolerance is detected.
    const ControlMesh closed = mesh_for(*find_scheme("catmull-clark"), k_closed);
    const Tessellation coarse = tessellate(closed, {.tolerance = 3e-2, .measure = false});
    const LimitJudge fine(closed, *find_scheme("catmull-clark"), 6);
    const double forward = fine.limit_to_mesh(coarse.mesh);
    CHECK(forward <= coarse.tolerance_absolute);
    CHECK(forward >= 0.3 * coarse.tolerance_absolute);
    CHECK(fine.mesh_to_limit(coarse.mesh) >= 0.3 * coarse.tolerance_absolute);
    CHECK(fine.doubt() < 0.05 * coarse.tolerance_absolute);
}

TEST_CASE("[slow] every model of data/ at 2e-2 and 6e-3: watertight, and within what was asked and certified") {
    for (const auto& entry : std::filesystem::directory_iterator(TETRAKIS_SOURCE_DIR "/data")) {
        if (entry.path().extension() != ".obj") continue;
        const std::string name = entry.path().stem().string();
        CAPTURE(name);
        const ControlMesh mesh = load_control_mesh(entry.path());
        const bool loop = name.ends_with("_tri") || name == "tetrahedron";
        for (const double tolerance : {2e-2, 6e-3})
            check_all(mesh, *find_scheme(loop ? "loop" : "catmull-clark"), tolerance, true, mesh.face_count() < 200);
    }
}

TEST_CASE("[slow] a small model at 1e-4: watertight, and within what was asked and certified") {
    check_all(load_control_mesh(TETRAKIS_SOURCE_DIR "/data/tetrahedron.obj"), *find_scheme("loop"), 1e-4);
}

TEST_CASE("[slow] random meshes with all tags, by Catmull-Clark, Loop and sqrt3") {
    for (const std::uint64_t seed : {1, 2, 5}) {
        CAPTURE(seed);
        check_all(test::random_sqrt3_mesh(seed), *find_scheme("sqrt3"), 2e-2);
    }
    for (const char* name : {"catmull-clark", "loop"})
        for (const std::uint64_t seed : test::seeds(10)) {
            CAPTURE(seed);
            const SchemeInfo& scheme = *find_scheme(name);
            test::RandomMeshOptions options = test::random_options(seed);
            options.columns = options.rows = 3;
            options.triangles_only = scheme.family == MeshFamily::triangles;
            const ControlMesh mesh = test::random_mesh(seed, options);
            std::uint32_t holes = 0;
            for (std::uint32_t f = 0; f < mesh.face_count(); ++f) holes += mesh.is_hole(FaceId(f));
            if (holes < mesh.face_count()) check_all(mesh, scheme, 2e-2);
        }
}

TEST_CASE("[slow] smooth random meshes, by every scheme") {
    for (const SchemeInfo& scheme : scheme_table())
        for (const std::uint64_t seed : test::seeds(2)) {
            CAPTURE(seed);
            check_all(mesh_for(scheme, ControlMesh::build(smooth_mesh(seed, scheme))), scheme, 5e-2);
        }
}

TEST_CASE("[slow] creases, darts, corners, semi-sharp tags, holes and open meshes, by every scheme") {
    struct Case {
        const char* what;
        std::string text;
        bool hole = false, semi_sharp = false, dart = false, for_dual = false;
    };
    const std::string closed = k_closed, tube = k_tube;
    const Case cases[] = {
        {"boundary", tube},
        {"crease that closes",
         closed + "t crease 2/1/0 0 1 10\nt crease 2/1/0 1 3 10\nt crease 2/1/0 3 2 10\nt crease 2/1/0 2 0 10\n"},
        {"dart", closed + "t crease 2/1/0 4 8 10\n", false, false, true},
        {"corner", closed + "t corner 1/1/0 8 10\n"},
        {"semi-sharp crease", closed + "t crease 2/1/0 4 8 2.5\nt crease 2/1/0 8 7 1\n", false, true},
        {"semi-sharp corner", closed + "t corner 1/1/0 8 1.5\n", false, true},
        {"corner with an angle of its own", closed + "t corner 1/1/0 8 10\nt cornerangle 2/1/0 8 5 110\n"},
        {"hole", closed + "t hole 1/0/0 1\n", true},
        {.what = "creases that cross",
         .text = closed + "t crease 2/1/0 4 8 10\nt crease 2/1/0 8 7 10\nt crease 2/1/0 8 5 10\nt crease 2/1/0 5 1 10\n"
                          "t corner 1/1/0 5 10\n",
         .for_dual = true},
        {.what = "semi-sharp creases of which the sharper go on where others have ended",
         .text = closed + "t crease 2/1/0 4 8 3\nt crease 2/1/0 8 7 2\nt crease 2/1/0 8 5 2.5\nt crease 2/1/0 5 1 3\n",
         .semi_sharp = true,
         .for_dual = true},
        {.what = "crease between boundaries",
         .text = tube + "t crease 2/1/0 0 4 10\nt crease 2/1/0 4 8 10\n",
         .for_dual = true},
        {.what = "creases that end at a boundary",
         .text = tube + "t crease 2/1/0 0 4 10\nt crease 2/1/0 1 5 2\nt crease 2/1/0 5 9 3\n",
         .semi_sharp = true,
         .for_dual = true},
    };
    for (const char* name : k_schemes)
        for (const Case& c : cases) {
            INFO(c.what);
            const SchemeInfo& scheme = *find_scheme(name);
            const bool dual = is_dual(scheme);
            if (c.for_dual && !dual) continue;
            if (scheme.refinement == Refinement::honeycomb && c.dart) {
                // There is no limit mask at the end of a crease.
                CHECK(code_of(mesh_for(scheme, c.text), {.scheme = scheme, .tolerance = 2e-2}, {}) ==
                      ErrorCode::unsupported);
                continue;
            }
            // The edge of a hole is an edge of none of their levels: see tests/eval/tessellate_schemes_test.cpp.
            if (dual && c.hole) continue;
            check_all(mesh_for(scheme, c.text), scheme, 4e-2, !(dual && c.semi_sharp));
        }
}

TEST_CASE("creases that stay semi-sharp for long are rounded off within the tolerance") {
    const SchemeInfo& scheme = *find_scheme("kobbelt");
    const std::string cube =
        "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n"
        "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    const ControlMesh mesh = mesh_for(scheme, cube + "t crease 2/1/0 0 1 5.5\nt crease 2/1/0 1 3 2\n");
    const Tessellation result = tessellate(mesh, {.scheme = scheme, .tolerance = 1e-3, .measure = false});
    CHECK(LimitJudge(mesh, scheme, 7).limit_to_mesh(result.mesh) <= result.tolerance_absolute);
}

TEST_CASE("a number of triangles is not spent on what is flat already") {
    for (const std::string name : {"catmull-clark", "loop", "sqrt3", "doo-sabin", "kobbelt"})
        for (const EstimatorKind estimator : {EstimatorKind::measured, EstimatorKind::certified}) {
            const SchemeInfo& scheme = *find_scheme(name);
            if (estimator == EstimatorKind::certified && !scheme_support(scheme).certified) continue;
            CAPTURE(name);
            const ControlMesh square = mesh_for(scheme, "v 0 0 3\nv 1 0 3\nv 1 1 3\nv 0 1 3\nf 1 2 3 4\n");
            const Tessellation result = tessellate(
                square,
                {.scheme = scheme, .estimator = estimator, .tolerance = {}, .max_triangles = 5000, .measure = true});
            CHECK(result.mesh.triangles.size() <= 18);
            REQUIRE(result.measured_error);
            CHECK(result.measured_error->hausdorff < 1e-13);
        }
}

TEST_CASE("[inv9] open meshes within a number of triangles are as good as to a tolerance, and proven") {
    for (const char* name : {"catmull-clark", "loop", "doo-sabin"})
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            const SchemeInfo& scheme = *find_scheme(name);
            CAPTURE(scheme.name);
            CAPTURE(seed);
            ControlMeshData data = test::grid(4, scheme.family == MeshFamily::triangles);
            std::mt19937 random(static_cast<unsigned>(seed));
            for (Vec3d& p : data.positions) p.z = std::uniform_real_distribution<double>(0, 1)(random);
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            TessellateOptions options{.scheme = scheme, .tolerance = 2e-3, .measure = true};
            const Tessellation wanted = tessellate(mesh, options);
            // If the number of triangles is not reached, the tolerance is.
            options.max_triangles = 1'000'000;
            const Tessellation plenty = tessellate(mesh, options);
            CHECK(plenty.tolerance_reached == (plenty.measured_error->hausdorff <= plenty.tolerance_absolute));
            if (!is_dual(scheme)) CHECK(plenty.tolerance_reached);
            options.tolerance = {};
            options.max_triangles = wanted.mesh.triangles.size();
            for (const EstimatorKind estimator : {measured, certified}) {
                options.estimator = estimator;
                const Tessellation result = tessellate(mesh, options);
                CHECK(result.measured_error->hausdorff < 1.5 * wanted.tolerance_absolute);
                REQUIRE(result.certified_error);
                CHECK(result.measured_error->hausdorff <= k_rounding * *result.certified_error);
            }
        }
}

TEST_CASE("[inv9] creases whose sharpness falls along them are proven, by Chaikin's method, too") {
    for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin})
        for (const float low : {0.05f, 0.1f, 0.7f, 1.2f}) {
            CAPTURE(low);
            ControlMeshData data = test::grid(6);
            data.crease_method = method;
            for (std::size_t v = 0; v < data.positions.size(); ++v)
                data.positions[v].z = std::sin(6 + 5 * static_cast<double>(v));
            for (std::uint32_t v = 21; v < 27; ++v) data.creases.push_back({v, v + 1, v < 24 ? 2.1f : low});
            const Tessellation result =
                tessellate(ControlMesh::build(std::move(data)),
                           {.scheme = "catmull-clark", .estimator = certified, .tolerance = 3e-4, .measure = true});
            REQUIRE(result.certified_error);
            CHECK(result.measured_error->hausdorff <= k_rounding * *result.certified_error);
        }
}

TEST_CASE("[inv9] beside folds with tags the measured distance back is that to the nearest part of the surface") {
    // On this cage Newton's method alone went over to another part, and measured 1.12 times the proven bound.
    ControlMeshData data;
    data.face_offsets = {0};
    data.positions = {{3.8, 0.6, -0.6},   {1.3, 1.0, 0.1},   {1.1, -0.1, -0.2}, {2.2, -0.8, -1.0},
                      {-0.3, 2.0, 0.4},   {1.4, 1.5, -0.4},  {-0.3, 1.9, -0.8}, {0.5, 2.5, -1.3},
                      {-2.0, -0.1, -0.4}, {-2.6, -0.5, 0.0}, {-0.6, -0.8, 0.3}, {-2.7, 0.5, -0.9},
                      {-0.3, -1.6, -0.1}, {0.1, -2.4, 0.8},  {-0.9, -1.6, 1.2}, {0.4, -1.3, -1.8}};
    for (std::uint32_t i = 0; i < 4; ++i)
        for (std::uint32_t j = 0; j < 4; ++j) {
            const std::uint32_t a = 4 * i, b = 4 * ((i + 1) % 4), k = (j + 1) % 4;
            for (const std::uint32_t v : {a + j, b + j, b + k, a + k}) data.face_vertices.push_back(v);
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        }
    data.creases = {{0, 1, 2.0f}, {0, 12, 10.0f}, {1, 13, 10.0f}, {2, 3, 10.0f}, {4, 7, 10.0f},
                    {5, 6, 0.5f}, {5, 9, 1.5f},   {8, 11, 3.3f},  {9, 10, 2.0f}, {14, 15, 1.5f}};
    data.corners = {{9, 10.0f}};
    const Tessellation result =
        tessellate(ControlMesh::build(std::move(data)),
                   {.scheme = "catmull-clark", .estimator = certified, .tolerance = 1e-2, .measure = true});
    REQUIRE(result.certified_error);
    CHECK(result.measured_error->hausdorff <= k_rounding * *result.certified_error);
}

TEST_CASE("[slow] a number of triangles is never exceeded, and the error falls as it grows") {
    for (const char* name : k_schemes) {
        const SchemeInfo& scheme = *find_scheme(name);
        CAPTURE(scheme.name);
        if (!scheme_support(scheme).adaptive) continue;
        const ControlMesh mesh = mesh_for(scheme, k_closed);
        double before = std::numeric_limits<double>::infinity();
        for (const std::uint64_t most : {150, 300, 601}) {
            CAPTURE(most);
            const Tessellation result = tessellate(mesh, {.scheme = scheme,
                                                          .tolerance = {},
                                                          .max_triangles = most,
                                                          .measure = true,
                                                          .measure_samples = k_samples});
            CHECK(result.mesh.triangles.size() <= most);
            if (scheme.smoothness != "C0") CHECK(10 * result.mesh.triangles.size() > 7 * most);
            if (result.certified_error) CHECK(result.measured_error->hausdorff <= *result.certified_error);
            check_watertight(mesh, result);
            // If several largest errors are equal, one more split does not reduce the maximum.
            CHECK(result.measured_error->hausdorff <= 1.05 * before + 1e-12 * diagonal(mesh));
            before = result.measured_error->hausdorff;
        }
        // With a tolerance that needs more triangles: the result is the best one, and reports this.
        const Tessellation missed =
            tessellate(mesh, {.scheme = scheme, .tolerance = 1e-5, .max_triangles = 300, .measure = false});
        if (scheme.smoothness != "C0") CHECK(!missed.tolerance_reached);
        CHECK(missed.mesh.triangles.size() <= 300);
        // With fewer triangles than the coarsest mesh: an error names a sufficient number.
        TessellateOptions few{.scheme = scheme, .tolerance = {}, .max_triangles = 3, .measure = false};
        const Error error = test::error_of([&] { tessellate(mesh, few); });
        CHECK(error.code() == ErrorCode::unsupported);
        const std::string message = error.what(), advice = "allow at least ";
        CAPTURE(message);
        REQUIRE(message.find(advice) != std::string::npos);
        few.max_triangles = std::stoull(message.substr(message.find(advice) + advice.size()));
        CHECK(few.max_triangles > 3);
        CHECK(tessellate(mesh, few).mesh.triangles.size() <= few.max_triangles);
        const TessellateOptions deep{
            .scheme = scheme, .tolerance = {}, .max_triangles = 300, .min_level = 4, .measure = false};
        CHECK(test::contains(test::error_of([&] { tessellate(mesh, deep); }).what(), "lower the minimum level"));
        // If a level or the number stops the refinement, the bound is that of the result.
        if (!scheme_support(scheme).certified || scheme.smoothness == "C0") continue;
        for (const auto& [triangles, level] : {std::pair{300, 28}, {0, 1}}) {
            CAPTURE(level);
            const Tessellation stopped = tessellate(mesh, {.scheme = scheme,
                                                           .estimator = EstimatorKind::certified,
                                                           .tolerance = 1e-5,
                                                           .max_triangles = static_cast<std::uint64_t>(triangles),
                                                           .max_level = level,
                                                           .measure = true,
                                                           .measure_samples = k_samples});
            CHECK_FALSE(stopped.tolerance_reached);
            CHECK(stopped.deepest_level <= level);
            CHECK(stopped.measured_error->hausdorff <= k_rounding * stopped.certified_error.value());
        }
    }
}

TEST_CASE("[slow] [inv10] one, two and three threads give the same bytes") {
    for (const char* name : k_schemes)
        for (const EstimatorKind estimator : {EstimatorKind::measured, EstimatorKind::certified}) {
            const SchemeInfo& scheme = *find_scheme(name);
            CAPTURE(scheme.name);
            if (estimator == EstimatorKind::certified && !scheme_support(scheme).certified) continue;
            ControlMeshData data = smooth_mesh(3, scheme);
            test::add_charts(data);
            const ControlMesh mesh = mesh_for(scheme, ControlMesh::build(std::move(data)));
            const TessellateOptions options{
                .scheme = scheme, .estimator = estimator, .tolerance = 8e-2, .measure = true, .measure_samples = 5'000};
            RunContext context;
            context.threads = 1;
            const Tessellation first = tessellate(mesh, options, context);
            for (context.threads = 2; context.threads <= 3; ++context.threads)
                check_same(first, tessellate(mesh, options, context));
        }
}

TEST_CASE("[slow] a callback cancels at any moment, and too little memory is said") {
    for (const char* name : k_schemes) {
        const SchemeInfo& scheme = *find_scheme(name);
        CAPTURE(scheme.name);
        const ControlMesh mesh = mesh_for(scheme, k_closed);
        for (const EstimatorKind estimator : {EstimatorKind::measured, EstimatorKind::certified}) {
            if (estimator == EstimatorKind::certified && !scheme_support(scheme).certified) continue;
            const TessellateOptions options{
                .scheme = scheme, .estimator = estimator, .tolerance = 0.1, .measure = false};
            std::size_t calls = 0;
            RunContext counting;
            counting.threads = 2;
            counting.progress = [&](std::string_view, double fraction) {
                CHECK(fraction >= 0);
                CHECK(fraction <= 1);
                return ++calls > 0;
            };
            CHECK(code_of(mesh, options, counting) == std::nullopt);
            REQUIRE(calls > 0);
            const std::size_t all = calls;
            TessellateOptions few = options;
            few.max_triangles = 4;  // fewer than the coarsest mesh has: progress still ends at 1
            code_of(mesh, few, counting);
            for (const double share : {0.0, 0.25, 0.5, 0.75}) {
                CAPTURE(share);
                std::size_t left = static_cast<std::size_t>(share * static_cast<double>(all));
                RunContext impatient;
                impatient.threads = 2;
                impatient.progress = [&](std::string_view, double) { return left-- > 0; };
                CHECK(code_of(mesh, options, impatient) == ErrorCode::cancelled);
            }
        }
        RunContext little;
        little.max_memory_bytes = 200'000;
        if (scheme.smoothness != "C0")
            CHECK(code_of(mesh, {.scheme = scheme, .tolerance = 1e-5, .measure = false}, little) ==
                  ErrorCode::memory_limit);
    }
}

TEST_CASE("materials and groups are those of the control face that a triangle comes from") {
    for (const char* name : k_schemes) {
        const SchemeInfo& scheme = *find_scheme(name);
        CAPTURE(scheme.name);
        ControlMeshData data = smooth_mesh(4, scheme);
        data.materials = {"wood", "stone", "glass"};
        data.groups = {"near", "far"};
        for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f) {
            data.face_material.push_back(f * f % 3);
            data.face_group.push_back(f / 5 % 2);
        }
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        const Tessellation result = tessellate(mesh, {.scheme = scheme, .tolerance = 0.1, .measure = false});
        CHECK(result.mesh.materials == mesh.data().materials);
        CHECK(result.mesh.groups == mesh.data().groups);
        const std::size_t count = result.mesh.triangles.size();
        REQUIRE(result.mesh.triangle_material.size() == count);
        REQUIRE(result.mesh.triangle_group.size() == count);
        std::size_t wrong = 0;
        for (std::size_t t = 0; t < count; ++t) {
            const std::uint32_t face = result.triangle_face[t];
            wrong += result.mesh.triangle_material[t] != mesh.data().face_material[face];
            wrong += result.mesh.triangle_group[t] != mesh.data().face_group[face];
        }
        CHECK(wrong == 0);
        if (is_dual(scheme) || scheme.refinement == Refinement::honeycomb) continue;
        CHECK(std::set(result.triangle_face.begin(), result.triangle_face.end()).size() == mesh.face_count());
    }
}

TEST_CASE("above 64 edges at a vertex there is no certified bound where limits are no polynomials, and that is said") {
    for (const std::uint32_t valence : {64u, 65u}) {
        CAPTURE(valence);
        ControlMeshData data;
        data.positions.push_back({0, 0, 1});
        data.face_offsets = {0};
        for (std::uint32_t i = 0; i < valence; ++i) {
            const double angle = 2 * 3.14159265358979 * i / valence;
            data.positions.push_back({std::cos(angle), std::sin(angle), 0});
            for (const std::uint32_t v : {0u, i + 1, (i + 1) % valence + 1}) data.face_vertices.push_back(v);
            data.face_offsets.push_back(3 * (i + 1));
        }
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        const bool few = valence <= 64;
        CHECK(scheme_support(mesh, "butterfly").certified == few);
        CHECK(scheme_support(mesh, "loop").certified);
        TessellateOptions options{.scheme = "butterfly", .tolerance = 0.05};
        CHECK(!tessellate(mesh, options).certified_error);
        options.estimator = EstimatorKind::certified;
        if (few)
            CHECK(tessellate(mesh, options).certified_error);
        else
            CHECK(test::contains(test::error_of([&] { tessellate(mesh, options); }).what(), "64 edges"));
    }
}

TEST_SUITE_END();
