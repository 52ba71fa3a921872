#include "../../eval/tessellate/tessellate.hpp"

#include "../kit/input_helpers.hpp"
#include "../kit/meshes.hpp"
#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/surface_topology.hpp"

#include "../../eval/distance/triangle_bvh.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/surface/height_image.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/adaptive/hierarchy.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <set>
#include <string>
#include <string_view>
#include <thread>

using namespace tetrakis;

namespace {

ControlMesh parse(const std::string& text) { return ControlMesh::build(parse_obj(text, "test.obj")); }

/// The cube [-1, 1]^3, each face with the whole unit square as its texture: seams along all edges.
std::string cube_text() {
    return "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\nv 1 1 1\n"
           "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
           "f 1/1 3/2 4/3 2/4\nf 5/1 6/2 8/3 7/4\nf 1/1 2/2 6/3 5/4\nf 4/1 3/2 7/3 8/4\nf 3/1 1/2 5/3 7/4\n"
           "f 2/1 4/2 8/3 6/4\n";
}

/// An n x n grid of squares on [0, 1]^2 with one UV chart; with `seam`, another chart right of the middle line.
ControlMeshData grid(std::uint32_t n, bool seam) {
    ControlMeshData data = test::grid(n);
    for (Vec3d& p : data.positions) p /= n;
    for (const double shift : {0.0, 0.3})
        for (const Vec3d& p : data.positions) data.uvs.emplace_back(0.6 * p.x + shift, p.y);
    const auto points = static_cast<std::uint32_t>(data.positions.size());
    for (std::uint32_t c = 0; c < data.face_vertices.size(); ++c)
        data.face_uvs.push_back(data.face_vertices[c] + (seam && 2 * (c / 4 % n) >= n ? points : 0));
    return data;
}

HeightImage waves() {
    HeightImage image{32, 32, {}};
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x)
            image.values.push_back(static_cast<float>(0.5 + 0.25 * std::sin(0.4 * x) + 0.25 * std::cos(0.3 * y)));
    return image;
}

void check_conforming(const ControlMesh& mesh, const Tessellation& result) {
    CHECK(test::topology(result.mesh.triangles) == test::surface_topology(mesh));
}

/// How far the UVs of a tessellation are from those at the corners of control faces, whose points are these, at most.
double corner_uvs_off(const ControlMesh& mesh, const Tessellation& result,
                      const std::function<Vec3d(HalfedgeId)>& point, const std::function<Vec2d(HalfedgeId)>& uv) {
    REQUIRE(result.mesh.triangle_uvs.size() == result.mesh.triangles.size());
    const PointMatch match(result.mesh.positions);
    double off = 0, uv_off = 0;
    std::size_t found = 0;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        const Vec3d p = point(HalfedgeId(h));
        const std::uint32_t v = match.nearest(p);
        off = std::max(off, glm::length(result.mesh.positions[v] - p));
        std::size_t here = 0;
        for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                if (result.mesh.triangles[t][k] == v && result.triangle_face[t] == mesh.face(HalfedgeId(h)).value) {
                    const Vec2d& there = result.mesh.uvs[result.mesh.triangle_uvs[t][k]];
                    uv_off = std::max(uv_off, glm::length(there - uv(HalfedgeId(h))));
                    ++here;
                }
        found += here > 0;
    }
    CHECK(off <= 1e-12 * mesh.bounding_box().diagonal());
    CHECK(found == mesh.halfedge_count());
    return uv_off;
}

ErrorCode code_of(const std::function<void()>& call, const std::string& words) {
    const Error error = test::error_of(call);
    CAPTURE(error.what());
    CHECK(test::contains(error.what(), words));
    return error.code();
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("a hole of the control mesh over a target of two large triangles is seen") {
    // A flat frame about a square hole, onto the whole square.
    const ControlMesh frame = parse(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.61 0.61 0\nv 0.64 0.61 0\nv 0.64 0.64 0\nv 0.61 0.64 0\n"
        "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nt corner 8/8/0 0 1 2 3 4 5 6 7 10 10 10 10 10 10 10 10\n");
    TriangleMesh square;
    square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 2e-3;
    options.target = &square;
    const Tessellation result = tessellate(frame, options);
    CHECK_FALSE(result.tolerance_reached);
    CHECK(result.measured_error->forward > 0.01);
    CHECK(result.measured_error->forward < 0.025);
}

TEST_CASE("a control mesh is projected onto a target within the tolerance") {
    // A cube onto the unit sphere.
    const ControlMesh mesh = parse(cube_text());
    const TriangleMesh sphere = shapes::sphere(32, 64, Vec3d(0), 1.0);
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 0.01;
    options.target = &sphere;
    options.measure_samples = 50'000;
    const Tessellation result = tessellate(mesh, options);
    check_conforming(mesh, result);
    CHECK(result.tolerance_reached);
    CHECK_FALSE(result.certified_error);
    CHECK(result.measured_error->hausdorff <= result.tolerance_absolute);
    const TriangleBvh there(sphere), back(result.mesh);
    double off = 0, forward = 0, backward = 0;
    for (const Vec3d& p : result.mesh.positions) off = std::max(off, there.closest(p).distance);
    CHECK(off < 1e-14);
    for (const auto& t : result.mesh.triangles) {
        const Vec3d middle =
            (result.mesh.positions[t[0]] + result.mesh.positions[t[1]] + result.mesh.positions[t[2]]) / 3.0;
        backward = std::max(backward, there.closest(middle).distance);
    }
    for (const Vec3d& p : sphere.positions) forward = std::max(forward, back.closest(p).distance);
    CHECK(backward <= result.tolerance_absolute);
    CHECK(forward <= result.tolerance_absolute);
    // Outward normals of the triangles themselves.
    for (std::size_t i = 0; i < result.mesh.positions.size(); ++i)
        CHECK(glm::dot(result.mesh.normals[i], result.mesh.positions[i]) > 0.95);
}

TEST_CASE("the far face of a thin target is no error") {
    // Two sheets, as near to each other as the rays along the normal reach.
    TriangleMesh target = shapes::square(0, 4);
    const TriangleMesh below = shapes::square(-0.05, 4);
    const auto base = static_cast<std::uint32_t>(target.positions.size());
    target.positions.insert(target.positions.end(), below.positions.begin(), below.positions.end());
    for (const auto& t : below.triangles) target.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    const ControlMesh mesh = parse(
        "v 0.2 0.2 0.01\nv 0.8 0.2 0.01\nv 0.8 0.8 0.01\nv 0.2 0.8 0.01\nf 1 2 3 4\nt interpolateboundary 1/0/0 1\n");
    TessellateOptions options;
    options.tolerance = 0.02;
    options.tolerance_is_absolute = true;
    options.target = &target;
    options.measure = false;
    const Tessellation result = tessellate(mesh, options);
    CHECK(result.mesh.triangles.size() < 100);
    for (const Vec3d& p : result.mesh.positions) CHECK(std::abs(p.z) < 1e-12);
}

TEST_CASE("what of a target the projection does not reach counts as error") {
    // Two squares, one above the other: all points find the lower one.
    const ControlMesh mesh = ControlMesh::build(grid(2, false));
    TriangleMesh target;
    for (const double z : {0.05, 3.0}) {
        const auto v = static_cast<std::uint32_t>(target.positions.size());
        for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {2.0, -1.0}, {2.0, 2.0}, {-1.0, 2.0}})
            target.positions.emplace_back(x, y, z);
        target.triangles.push_back({v, v + 1, v + 2});
        target.triangles.push_back({v, v + 2, v + 3});
    }
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 0.01;
    options.target = &target;
    const Tessellation result = tessellate(mesh, options);
    CHECK_FALSE(result.tolerance_reached);
    CHECK(result.measured_error->forward > 2.9);
    REQUIRE(result.warnings.size() == 1);
    CHECK(result.warnings[0].find("the target is up to 3") == 0);
    CHECK(result.warnings[0].find("times the tolerance away from the mesh, though every part of the mesh is within") !=
          std::string::npos);
    CHECK(result.warnings[0].find("does not cover") != std::string::npos);
    CHECK(result.measured_error->backward < 0.01);
    CHECK(result.mesh.triangles.size() < 10'000);
}

TEST_CASE("a displacement stands on the limit surface along its normal") {
    const ControlMesh mesh = ControlMesh::build(grid(4, false));
    const HeightImage image = waves();
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 2e-3;
    options.displacement = &image;
    options.amplitude = 0.1;
    options.measure_samples = 50'000;
    const Tessellation result = tessellate(mesh, options);
    check_conforming(mesh, result);
    CHECK(result.tolerance_reached);
    CHECK_FALSE(result.certified_error);
    CHECK(result.measured_error->hausdorff <= result.tolerance_absolute);
    // The plane stays where it is, so each vertex knows its UV: heights are the image's.
    REQUIRE(!result.mesh.uvs.empty());
    for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d p = result.mesh.positions[result.mesh.triangles[t][k]];
            const Vec2d uv = result.mesh.uvs[result.mesh.triangle_uvs[t][k]];
            CHECK(p.z == doctest::Approx(0.1 * image.sample(uv)).epsilon(1e-9));
        }
}

TEST_CASE("[slow] [inv3] a displacement opens no crack at seams and creases") {
    const HeightImage image = waves();
    for (const int kind : {0, 1, 2}) {
        CAPTURE(kind);
        // A seam in a plane; a cube of seams; the same with all edges creased.
        ControlMeshData data = kind == 0 ? grid(4, true) : parse_obj(cube_text(), "cube.obj");
        if (kind == 2)
            for (std::uint32_t a = 0; a < 8; ++a)
                for (const std::uint32_t bit : {1u, 2u, 4u})
                    if ((a & bit) == 0) data.creases.push_back({a, a | bit, 10});
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        TessellateOptions options;
        options.measure = true;
        options.tolerance = 0.02;
        options.displacement = &image;
        options.amplitude = 0.1;
        options.measure_samples = 50'000;
        const Tessellation result = tessellate(mesh, options);
        check_conforming(mesh, result);
        CHECK(result.measured_error->forward <= result.tolerance_absolute);
        // What bridges the gap between the displaced sides of a seam or crease has no surface to be near to, so the way
        // back need not come within the tolerance.
        CHECK(result.mesh.triangles.size() < 60'000);
        // Two UVs at seam vertices, one position.
        std::map<std::uint32_t, std::set<std::uint32_t>> uvs_of;
        for (std::size_t t = 0; t < result.mesh.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                uvs_of[result.mesh.triangles[t][k]].insert(result.mesh.triangle_uvs[t][k]);
        std::size_t split = 0;
        for (const auto& [v, uvs] : uvs_of) split += uvs.size() > 1;
        CHECK(split > 3);
    }
}

TEST_CASE("UVs at control corners are those of the UV layer's own limit, by every face-varying rule") {
    for (const FaceVaryingRule rule :
         {FaceVaryingRule::smooth_all, FaceVaryingRule::corners_only, FaceVaryingRule::linear_all})
        for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop}) {
            CAPTURE(static_cast<int>(rule));
            INFO(name(scheme));
            ControlMeshData data = grid(4, true);
            // Bent, so that limits differ from the control values.
            for (Vec2d& uv : data.uvs) uv = {uv.x + 0.1 * uv.y * uv.y, uv.y + 0.15 * uv.x * uv.x};
            data.face_varying_rule = rule;
            data.boundary_rule =
                rule == FaceVaryingRule::smooth_all ? BoundaryRule::edge_only : BoundaryRule::edge_and_corner;
            ControlMesh mesh = ControlMesh::build(std::move(data));
            if (scheme == SchemeKind::loop) mesh = triangulate(mesh);
            ControlMeshData layer;
            for (const Vec2d& uv : mesh.data().uvs) layer.positions.emplace_back(uv.x, uv.y, 0);
            layer.face_offsets = mesh.data().face_offsets;
            layer.face_vertices = mesh.data().face_uvs;
            layer.boundary_rule = mesh.boundary_rule();
            // Those of triangulated corners.
            std::set<std::uint32_t> sharp;
            for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
                if (mesh.sharpness(mesh.origin(HalfedgeId(h))) > 0) sharp.insert(mesh.uv_index(HalfedgeId(h)));
            for (const std::uint32_t uv : sharp) layer.corners.push_back({uv, k_infinite_sharpness});
            const ControlMesh uv_mesh = ControlMesh::build(std::move(layer));
            const Hierarchy uv_limit = make_hierarchy(uv_mesh, name(scheme)),
                            limit = make_hierarchy(mesh, name(scheme));
            TessellateOptions options;
            options.scheme = scheme;
            options.tolerance = 1e-2;
            options.min_level = 1;
            options.measure = false;
            const Tessellation result = tessellate(mesh, options);
            REQUIRE(result.warnings.empty());
            const auto limit_of = [&](const Hierarchy& points, HalfedgeId h) {
                const HalfedgeId root = scheme == SchemeKind::loop ? mesh.face_halfedge(mesh.face(h)) : h;
                constexpr LatticePoint corners[3] = {{0, 0}, {1, 0}, {0, 1}};
                const Site site{root, corners[h.value - root.value], 0};
                Vec3d at;
                points.limit_positions({&site, 1}, {&at, 1});
                return at;
            };
            const auto uv_of = [&](HalfedgeId h) {
                return rule == FaceVaryingRule::linear_all ? mesh.data().uvs[mesh.uv_index(h)]
                                                           : Vec2d(limit_of(uv_limit, h));
            };
            CHECK(corner_uvs_off(
                      mesh, result, [&](HalfedgeId h) { return limit_of(limit, h); }, uv_of) < 1e-12);
        }
}

TEST_CASE("texture coordinates at the corners of control faces are the given ones where the rule keeps them") {
    // Vertices stay where they are: of interpolating schemes, and elsewhere as corners.
    for (const char* name : {"catmull-clark", "loop", "tuned-loop", "4-8", "kobbelt", "butterfly", "bilinear"}) {
        const SchemeInfo& scheme = *find_scheme(name);
        CAPTURE(scheme.name);
        ControlMeshData data = test::mesh_for(scheme, ControlMesh::build(test::skewed_grid(3))).data();
        test::add_charts(data);
        data.face_varying_rule = FaceVaryingRule::linear_all;
        if (!scheme.interpolating)
            for (std::uint32_t v = 0; v < data.positions.size(); ++v)
                data.corners.push_back({v, k_infinite_sharpness, 0});
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        TessellateOptions options{.scheme = scheme, .tolerance = 0.1, .measure = false};
        const Tessellation result = tessellate(mesh, options);
        const auto point = [&](HalfedgeId h) { return mesh.position(mesh.origin(h)); };
        const auto given = [&](HalfedgeId h) { return mesh.data().uvs[mesh.uv_index(h)]; };
        CHECK(corner_uvs_off(mesh, result, point, given) < 1e-10);
        options.uvs = false;
        CHECK(tessellate(mesh, options).mesh.uvs.empty());
        CHECK(tessellate(mesh, options).mesh.triangle_uvs.empty());
    }
}

TEST_CASE("linear UVs are bilinear in the corner cells") {
    const ControlMesh mesh = parse(cube_text() + "t facevaryinginterpolateboundary 1/0/0 5\n");
    TessellateOptions options;
    options.tolerance = 0.01;
    options.min_level = 3;
    options.max_level = 3;
    options.measure = false;
    const Tessellation result = tessellate(mesh, options);
    std::set<std::pair<double, double>> distinct;
    for (const Vec2d& uv : result.mesh.uvs) {
        CHECK(std::abs(16 * uv.x - std::round(16 * uv.x)) < 1e-12);
        CHECK(std::abs(16 * uv.y - std::round(16 * uv.y)) < 1e-12);
        distinct.insert({uv.x, uv.y});
    }
    // The corners of an 8 x 8 grid and the centres of its cells.
    CHECK(distinct.size() == 9 * 9 + 8 * 8);
}

TEST_CASE("options that cannot be meant are refused with advice") {
    const ControlMesh cube = parse(cube_text()), bare = parse("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    const HeightImage image = waves();
    const TriangleMesh empty;
    TriangleMesh broken;
    broken.positions = {{0, 0, 0}, {1, 0, 0}};
    broken.triangles = {{0, 1, 2}};
    const auto refuse = [&](const ControlMesh& mesh, const std::string& words, auto&& set) {
        INFO(words);
        TessellateOptions options;
        options.tolerance = 0.01;
        set(options);
        CHECK(code_of([&] { tessellate(mesh, options); }, words) == ErrorCode::invalid_input);
    };
    refuse(cube, "at least one of them", [](auto& o) { o.tolerance.reset(); });
    refuse(cube, "positive", [](auto& o) { o.tolerance = 0; });
    refuse(cube, "positive", [](auto& o) { o.tolerance = -1; });
    refuse(cube, "positive", [](auto& o) { o.tolerance = std::nan(""); });
    refuse(cube, "positive", [](auto& o) { o.tolerance = std::numeric_limits<double>::infinity(); });
    refuse(cube, "levels must be", [](auto& o) { o.min_level = -1; });
    refuse(cube, "levels must be", [](auto& o) { o.max_level = 31; });
    refuse(cube, "levels must be", [](auto& o) { o.min_level = 3, o.max_level = 2; });
    refuse(bare, "texture coordinates", [&](auto& o) { o.displacement = &image; });
    refuse(cube, "amplitude", [&](auto& o) { o.displacement = &image, o.amplitude = std::nan(""); });
    refuse(cube, "use the measured estimator",
           [&](auto& o) { o.displacement = &image, o.estimator = EstimatorKind::certified; });
    refuse(cube, "no triangles", [&](auto& o) { o.target = &empty; });
    refuse(cube, "uses vertex 2, but there are 2 vertices", [&](auto& o) { o.target = &broken; });
    refuse(cube, "triangulate", [](auto& o) { o.scheme = SchemeKind::loop; });
    refuse(ControlMesh(), "no faces", [](auto&) {});
}

TEST_CASE("the certified estimator leaves room for the rounding of written floats, and says where there is none") {
    ControlMeshData data = parse_obj(cube_text(), "cube.obj");
    for (Vec3d& p : data.positions) p = p * 3.0;
    data.holes = {0, 1, 2, 3, 4};  // one face tells as much as six
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    TessellateOptions options;
    options.estimator = EstimatorKind::certified;
    options.tolerance_is_absolute = true;
    options.floats_written = true;
    options.measure = false;
    for (const double tolerance : {1e-3, 2e-5}) {
        options.tolerance = tolerance;
        const Tessellation result = tessellate(mesh, options);
        CHECK(result.tolerance_absolute == tolerance);
        CHECK(*result.certified_error <= tolerance);
        CHECK(*result.certified_error > 0.9 * tolerance);
        CHECK(result.tolerance_reached);
        CHECK(result.warnings.empty());
    }
    options.tolerance = 1e-7;      // coordinates up to 3 in floats: off by up to 3e-7
    options.max_triangles = 2000;  // what matters is said before any refinement
    for (const EstimatorKind kind : {EstimatorKind::certified, EstimatorKind::measured}) {
        options.estimator = kind;
        const Tessellation result = tessellate(mesh, options);
        CHECK(!result.tolerance_reached);
        REQUIRE(result.warnings.size() == 1);
        CHECK(result.warnings[0].find("floats that are written may be off by") != std::string::npos);
        CHECK(result.warnings[0].find("(.obj or .ply)") != std::string::npos);
    }
}

TEST_CASE("rounding to the floats of a GLB is bounded for whatever lies inside a box") {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 20000; ++i) {
        Box3d outer, inner;
        const Vec3d at(8 * unit(random), 8 * unit(random), 0);
        for (int k = 0; k < 2; ++k) outer.add(at + 2.0 * Vec3d(unit(random), unit(random), unit(random)));
        for (int k = 0; k < 2; ++k)
            inner.add(outer.lower + Vec3d(unit(random), unit(random), unit(random)) * (outer.upper - outer.lower));
        REQUIRE(glb_rounding_bound(inner) <= glb_rounding_bound_within(outer));
    }
}

TEST_CASE("mean and RMS are of actual distances also where Newton's method gets stuck at a fold") {
    // A sheet folded to and fro, flat but for a ripple: beside the folds Newton's bounds are far above the distances.
    constexpr double k_column[7] = {0, 1, 2, 1.2, 2.2, 3, 4};
    for (const double ripple : {1e-4, 0.0}) {
        ControlMeshData data = grid(6, false);
        for (std::uint32_t v = 0; v < data.positions.size(); ++v)
            data.positions[v] = {k_column[v % 7], v / 7, ripple * std::sin(v)};
        TessellateOptions options;
        options.measure = true;
        options.tolerance = 0.1;
        const auto measured = tessellate(ControlMesh::build(std::move(data)), options).measured_error;
        REQUIRE(measured);
        CHECK(measured->mean < 0.5 * measured->hausdorff);
        CHECK(measured->mean <= measured->rms);
        CHECK(measured->rms < 0.9 * measured->hausdorff);
    }
}

TEST_CASE("isolated vertices weigh nothing in a relative tolerance") {
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 1e-2;
    const Tessellation a = tessellate(parse(cube_text()), options);
    ControlMeshData data = parse_obj(cube_text(), "cube.obj");
    data.positions.emplace_back(90, 0, 0);
    data.vertex_lines.clear();
    const Tessellation b = tessellate(ControlMesh::build(std::move(data)), options);
    CHECK(a.tolerance_absolute == doctest::Approx(1e-2 * std::sqrt(12.0)).epsilon(1e-15));
    CHECK(b.tolerance_absolute == a.tolerance_absolute);
    CHECK(b.mesh.triangles == a.mesh.triangles);
}

TEST_CASE("[bad-input] coordinates are as large as their fourth powers allow, or refused") {
    const auto scaled = [](double factor) {
        ControlMeshData data = parse_obj(cube_text(), "cube.obj");
        for (Vec3d& p : data.positions) p *= factor;
        return data;
    };
    TessellateOptions options;
    options.measure = true;
    options.tolerance = 1e-2;
    const Tessellation small = tessellate(ControlMesh::build(scaled(1)), options);
    const Tessellation large = tessellate(ControlMesh::build(scaled(1e55)), options);
    CHECK(large.tolerance_reached);
    CHECK(large.mesh.triangles.size() ==
          doctest::Approx(static_cast<double>(small.mesh.triangles.size())).epsilon(0.1));
    CHECK(large.measured_error->hausdorff == doctest::Approx(1e55 * small.measured_error->hausdorff).epsilon(0.1));
    CHECK(*large.certified_error == doctest::Approx(1e55 * *small.certified_error).epsilon(0.1));
    CHECK(code_of([&] { ControlMesh::build(scaled(1e70)); }, "has a coordinate beyond 1e+60") ==
          ErrorCode::invalid_input);
    const ControlMesh tiny = parse("v 0 0 0\nv 1e-80 0 0\nv 1e-80 1e-80 0\nv 0 1e-80 0\nf 1 2 3 4\n");
    CHECK(code_of([&] { tessellate(tiny, options); }, "scale it up") == ErrorCode::invalid_input);
}

TEST_CASE("[inv3] beside an interior vertex of valence 2 no edge has more than two triangles") {
    // A pillow of two triangles: three such vertices.
    const ControlMesh mesh = parse("v 0 0 0\nv 1 0 0.1\nv 1 1 -0.3\nf 1 2 3\nf 3 2 1\n");
    for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop})
        for (const double tolerance : {0.3, 1e-2, 1e-3}) {
            CAPTURE(int(scheme));
            CAPTURE(tolerance);
            TessellateOptions options;
            options.scheme = scheme;
            options.tolerance = tolerance;
            options.measure = false;
            const Tessellation result = tessellate(mesh, options);
            check_conforming(mesh, result);
        }
}

TEST_CASE("with a number of triangles the progress is their share of it, in the calling thread, and never goes back") {
    double last = 0;
    std::size_t steps = 0;
    const auto caller = std::this_thread::get_id();
    RunContext context;
    context.threads = 2;
    context.progress = [&](std::string_view stage, double fraction) {
        CHECK(std::this_thread::get_id() == caller);
        if (stage != "refine") return true;
        CHECK(fraction >= last);
        steps += fraction > last;
        last = fraction;
        return true;
    };
    TessellateOptions options;
    options.max_triangles = 5000;
    options.measure = false;
    tessellate(parse(cube_text()), options, context);
    CHECK(last > 0.99);
    CHECK(steps > 10);
}

TEST_CASE("[bad-input] no tolerance below what rounding takes is certified") {
    ControlMeshData far = parse(cube_text()).data();
    for (Vec3d& p : far.positions) p += Vec3d(1e6, 0, 0);
    const ControlMesh mesh = ControlMesh::build(std::move(far));
    TessellateOptions options;
    options.estimator = EstimatorKind::certified;
    options.measure = false;
    options.tolerance_is_absolute = true;
    options.tolerance = 1e-7;
    CHECK_THROWS_AS(tessellate(mesh, options), Error);
    options.tolerance = 1e-2;
    CHECK(*tessellate(mesh, options).certified_error <= 1e-2);
}

TEST_SUITE_END();
