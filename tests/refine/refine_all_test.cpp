#include "../kit/point_match.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/rules/rule_refinement.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../refine/uniform/uniform.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <set>
#include <string>

using namespace tetrakis;

namespace {

ControlMesh model(const std::string& name) {
    return ControlMesh::build(read_obj(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / (name + ".obj")));
}

ControlMesh fitting(const SchemeInfo& scheme, const ControlMesh& mesh) {
    return scheme.family == MeshFamily::triangles ? triangulate(mesh) : mesh;
}

/// n x n quads over the unit square, raised, with UVs equal to x and y, two materials, and a hole.
ControlMeshData sheet(std::uint32_t n, bool hole) {
    ControlMeshData data;
    data.face_offsets.push_back(0);
    for (std::uint32_t y = 0; y <= n; ++y)
        for (std::uint32_t x = 0; x <= n; ++x) {
            data.positions.push_back({double(x) / n, double(y) / n, 0.1 * ((x * 7 + y * 3) % 5)});
            data.uvs.push_back({double(x) / n, double(y) / n});
        }
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x) {
            const std::uint32_t v = y * (n + 1) + x;
            for (const std::uint32_t w : {v, v + 1, v + n + 2, v + n + 1}) {
                data.face_vertices.push_back(w);
                data.face_uvs.push_back(w);
            }
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
            data.face_material.push_back((x + y) % 2);
        }
    data.materials = {"even", "odd"};
    // No corners, which the triangulated mesh would keep and its charts not.
    data.boundary_rule = BoundaryRule::edge_only;
    data.face_varying_rule = FaceVaryingRule::smooth_all;
    if (hole) data.holes = {n + 1};
    return data;
}

bool same_bytes(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3d)) == 0);
}

double most_apart(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    REQUIRE(a.size() == b.size());
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, glm::length(a[i] - b[i]));
    return most;
}

RefineOptions on_threads(int threads) {
    RefineOptions options;
    options.context.threads = threads;
    return options;
}

struct Values {
    std::vector<Vec3d> positions, normals;
};

Values values(const RuleRefiner& refiner, const ControlMesh& mesh, bool normals) {
    Values result{std::vector<Vec3d>(refiner.vertex_count()), {}};
    refiner.refine(mesh.positions(), result.positions);
    if (!normals) return result;
    result.normals.resize(refiner.vertex_count());
    refiner.normals(mesh.positions(), result.normals);
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv7] [inv10] every scheme: stencils sum to one, give the points, and the threads do not matter") {
    for (const std::string name : {"cube", "pipe3", "extruded_pentagon"})
        for (const SchemeInfo& scheme : scheme_table()) {
            CAPTURE(name);
            CAPTURE(scheme.name);
            const ControlMesh mesh = fitting(scheme, model(name));
            const RuleRefiner refiner(mesh, scheme, 2);
            const Values one = values(refiner, mesh, false);
            const StencilTable table = refiner.stencils();
            REQUIRE(table.row_count() == static_cast<int>(refiner.vertex_count()));
            double sums = 0, points = 0;
            for (int v = 0; v < table.row_count(); ++v) {
                double sum = 0;
                Vec3d p(0);
                for (std::size_t i = 0; i < table.points(v).size(); ++i) {
                    sum += table.weights(v)[i];
                    p += table.weights(v)[i] * mesh.positions()[table.points(v)[i]];
                }
                sums = std::max(sums, std::abs(sum - 1));
                points = std::max(points, glm::length(p - one.positions[v]));
            }
            CHECK(sums < 1e-13);
            CHECK(points < 1e-13 * mesh.bounding_box().diagonal());
            const PolygonMesh single = refine(mesh, scheme, 2, on_threads(1));
            for (const int threads : {2, 4}) {
                const PolygonMesh more = refine(mesh, scheme, 2, on_threads(threads));
                CHECK(same_bytes(single.positions, more.positions));
                CHECK(single.face_vertices == more.face_vertices);
            }
            // Interpolating schemes keep the control vertices, bit for bit.
            if (scheme.interpolating)
                for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
                    REQUIRE(one.positions[v] == mesh.position(VertexId(v)));
        }
}

TEST_CASE("limits of primal schemes are the same seen from any level, and are approached") {
    for (const std::string name : {"cube", "pipe3", "extruded_pentagon"})
        for (const SchemeInfo& scheme : scheme_table()) {
            if (scheme.lattice == FanLattice::dual) continue;
            CAPTURE(name);
            CAPTURE(scheme.name);
            const ControlMesh mesh = fitting(scheme, model(name));
            const double size = mesh.bounding_box().diagonal();
            const RefineOptions options{.limit = true, .normals = true};
            const RuleRefiner first(mesh, scheme, 1, options), second(mesh, scheme, 2, options);
            const Values a = values(first, mesh, true), b = values(second, mesh, true);
            std::vector<Vec3d> seen(b.positions.begin(), b.positions.begin() + first.vertex_count());
            CHECK(most_apart(a.positions, seen) < 1e-11 * size);
            // Bilinear surfaces and corners have no normals of their own.
            if (scheme.name != "bilinear" && scheme.name != "midpoint") {
                int differ = 0;
                for (std::uint32_t v = 0; v < first.vertex_count(); ++v)
                    if (first.last().rule(static_cast<int>(v)) != VertexRule::corner &&
                        glm::length(a.normals[v] - b.normals[v]) > 1e-9)
                        ++differ;
                CHECK(differ == 0);
            }
            const Values deep = values(RuleRefiner(mesh, scheme, 3), mesh, false);
            seen.assign(deep.positions.begin(), deep.positions.begin() + first.vertex_count());
            CHECK(most_apart(a.positions, seen) < 0.04 * size);
        }
}

TEST_CASE("limits of creases that stay semi-sharp for long, and end or meet: from any level the same, and approached") {
    // A cube's edges: a loop around a face, three in a corner, one that ends at both of its ends.
    const auto cube = [](float scale) {
        ControlMeshData data = read_obj(std::filesystem::path(TETRAKIS_SOURCE_DIR) / "data" / "cube.obj");
        const std::vector<std::uint32_t>& f = data.face_vertices;
        for (std::uint32_t i = 0; i < 4; ++i) data.creases.push_back({f[i], f[(i + 1) % 4], scale * (1 + 0.3f * i)});
        data.creases.push_back({f[4], f[5], scale});
        data.creases.push_back({f[9], f[10], 0.5f * scale});
        return ControlMesh::build(std::move(data));
    };
    for (const float scale : {1.3f, 4.5f})
        for (const SchemeInfo& scheme : scheme_table()) {
            if (scheme.family == MeshFamily::hexagons || scheme.name == "bilinear" || scheme.name == "midpoint")
                continue;
            CAPTURE(scheme.name);
            CAPTURE(scale);
            const ControlMesh mesh = fitting(scheme, cube(scale));
            const RefineOptions options{.limit = true};
            const RuleRefiner first(mesh, scheme, 1, options);
            const Values a = values(first, mesh, false);
            if (scheme.lattice == FanLattice::dual) {
                const PolygonMesh deep = refine(mesh, scheme, 6);
                const PointMatch in_deep(deep.positions);
                double worst = 0;
                for (const Vec3d& p : a.positions)
                    worst = std::max(worst, glm::length(p - deep.positions[in_deep.nearest(p)]));
                CHECK(worst < 0.01 * mesh.bounding_box().diagonal());
                continue;
            }
            const Values b = values(RuleRefiner(mesh, scheme, 2, options), mesh, false);
            const std::vector<Vec3d> seen(b.positions.begin(), b.positions.begin() + first.vertex_count());
            CHECK(most_apart(a.positions, seen) < 1e-11 * mesh.bounding_box().diagonal());
        }
}

TEST_CASE("limits of dual schemes: the splines' on a regular mesh, on a sphere's inside elsewhere") {
    // A torus of 8 x 8 quads: 1/64 (1, 6, 1) x (1, 6, 1) for biquadratic splines.
    constexpr int n = 8;
    ControlMeshData data;
    data.face_offsets.push_back(0);
    const auto at = [](int x, int y) { return static_cast<std::uint32_t>((y + n) % n * n + (x + n) % n); };
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) data.positions.push_back({std::sin(x * 1.7 + y), std::cos(y * 2.1 - x), x * y % 7});
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            for (const std::uint32_t v : {at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)})
                data.face_vertices.push_back(v);
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        }
    const ControlMesh torus = ControlMesh::build(std::move(data));
    const RefineOptions limit{.limit = true};
    // Weights of a spline's control points at the parameter of the middle one: degree 2, and 4 at its own.
    const double quadratic[] = {0, 1.0 / 8, 6.0 / 8, 1.0 / 8, 0};
    const double quartic[] = {1.0 / 384, 76.0 / 384, 230.0 / 384, 76.0 / 384, 1.0 / 384};
    for (const std::string name : {"doo-sabin", "doo-sabin-cc", "biquartic"}) {
        CAPTURE(name);
        const double* w = name == "biquartic" ? quartic : quadratic;
        const PolygonMesh mesh = refine(torus, name, 0, limit);
        double most = 0;
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) {
                Vec3d sum(0);
                for (int j = -2; j <= 2; ++j)
                    for (int i = -2; i <= 2; ++i) sum += w[i + 2] * w[j + 2] * torus.positions()[at(x + i, y + j)];
                most = std::max(most, glm::length(sum - mesh.positions[at(x, y)]));
            }
        CHECK(most < 1e-12);
    }
    // At extraordinary points and boundaries: the finest faces around have come near.
    for (const std::string name : {"doo-sabin", "doo-sabin-cc", "midedge", "midedge-simplest"})
        for (const std::string input : {"cube", "pipe3", "extruded_pentagon"}) {
            CAPTURE(name);
            CAPTURE(input);
            const ControlMesh mesh = model(input);
            const RefineOptions both{.limit = true, .normals = true};
            const PolygonMesh limits = refine(mesh, name, 1, both), deep = refine(mesh, name, 4);
            double most = 0;
            for (std::size_t v = 0; v < limits.positions.size(); ++v) {
                CHECK(glm::length(limits.normals[v]) == doctest::Approx(1));
                double nearest = 1e9;
                for (const Vec3d& p : deep.positions) nearest = std::min(nearest, glm::length(p - limits.positions[v]));
                most = std::max(most, nearest);
            }
            CHECK(most < 0.04 * mesh.bounding_box().diagonal());
        }
}

TEST_CASE("limits of honeycomb refinement are the same seen from any level, and are approached") {
    for (const std::string name : {"cube", "pipe3", "extruded_pentagon"}) {
        CAPTURE(name);
        const ControlMesh mesh = model(name);
        const SchemeInfo& scheme = *find_scheme("honeycomb");
        const RefineOptions limit{.limit = true};
        const Values first = values(RuleRefiner(mesh, scheme, 0, limit), mesh, false),
                     third = values(RuleRefiner(mesh, scheme, 3, limit), mesh, false),
                     fourth = values(RuleRefiner(mesh, scheme, 4), mesh, false);
        const double size = mesh.bounding_box().diagonal();
        double moved = 0, away = 0;
        for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
            moved = std::max(moved, glm::length(first.positions[v] - third.positions[v]));
            away = std::max(away, glm::length(first.positions[v] - fourth.positions[v]));
        }
        CHECK(moved < 1e-12 * size);
        CHECK(away < 0.01 * size);
        const RuleRefiner refiner(mesh, scheme, 0, limit);
        const StencilTable table = refiner.stencils();
        for (int v = 0; v < table.row_count(); ++v) {
            double sum = 0;
            for (const double w : table.weights(v)) sum += w;
            CHECK(sum == doctest::Approx(1).epsilon(1e-13));
        }
    }
}

TEST_CASE("[inv1] one call, every scheme: the structured path is the rules' result; attributes come along") {
    for (const std::string name : {"loop", "catmull-clark", "bilinear", "midpoint"}) {
        CAPTURE(name);
        const ControlMesh mesh = fitting(*find_scheme(name), model("pipe3"));
        const RefineOptions limit{.limit = true};
        const PolygonMesh fast = refine(mesh, name, 3, limit),
                          plain = refine_stencils(mesh, *find_scheme(name), 3, limit).mesh;
        CHECK(fast.face_count() == plain.face_count());
        REQUIRE(fast.positions.size() == plain.positions.size());
        const PointMatch match(plain.positions);
        std::set<std::uint32_t> met;
        double most = 0;
        for (const Vec3d& p : fast.positions) {
            met.insert(match.nearest(p));
            most = std::max(most, glm::length(p - plain.positions[match.nearest(p)]));
        }
        CHECK(most < 1e-13 * mesh.bounding_box().diagonal());
        CHECK(met.size() == plain.positions.size());
    }
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        const ControlMesh whole = fitting(scheme, ControlMesh::build(sheet(4, false))),
                          holed = fitting(scheme, ControlMesh::build(sheet(4, true)));
        const PolygonMesh a = refine(whole, scheme, 2), b = refine(holed, scheme, 2);
        CHECK(b.face_count() < a.face_count());
        CHECK(a.face_material.size() == a.face_count());
        CHECK(b.face_material.size() == b.face_count());
        for (const auto* mesh : {&a, &b}) {
            std::vector<char> used(mesh->positions.size(), 0);
            for (const std::uint32_t v : mesh->face_vertices) used.at(v) = 1;
            CHECK(std::count(used.begin(), used.end(), 0) == 0);
            REQUIRE(mesh->face_uvs.size() == mesh->face_vertices.size());
            // One chart that is the mesh seen from above, with the same corners and boundary: so are its refinements.
            double most = 0;
            for (std::size_t c = 0; c < mesh->face_uvs.size(); ++c)
                most = std::max(
                    most, glm::length(mesh->uvs[mesh->face_uvs[c]] - Vec2d(mesh->positions[mesh->face_vertices[c]])));
            CHECK(most < 1e-13);
        }
        CHECK(a.warnings.empty());
    }
}

TEST_CASE("limits where boundaries recede: the part of the mesh that is on the surface") {
    const ControlMesh mesh = ControlMesh::build(sheet(6, false));
    RefineOptions options;
    options.rules.averaging_boundary = AveragingBoundary::recede;
    const PolygonMesh deep = refine(mesh, "biquartic", 6, options);
    const PointMatch in_deep(deep.positions);
    options.limit = options.normals = true;
    for (const int level : {1, 2}) {
        CAPTURE(level);
        const PolygonMesh limits = refine(mesh, "biquartic", level, options);
        // A quartic spline with 7 control points a side has three pieces; their points go from one end to the other.
        const std::size_t side = 3u * (1u << level);
        CHECK(limits.positions.size() == side * side);
        CHECK(limits.face_count() == (side - 1) * (side - 1));
        CHECK(limits.normals.size() == limits.positions.size());
        for (const Vec3d& p : limits.positions) CHECK(glm::length(p - deep.positions[in_deep.nearest(p)]) < 4e-3);
    }
}

TEST_CASE("two averaging steps are Catmull-Clark where four edges meet, creases and corners included") {
    ControlMeshData data = sheet(6, false);
    const auto at = [](std::uint32_t x, std::uint32_t y) { return 7 * y + x; };
    for (std::uint32_t i = 1; i < 5; ++i) data.creases.push_back({at(i, 2), at(i + 1, 2), 10});
    for (std::uint32_t i = 2; i < 5; ++i) data.creases.push_back({at(3, i), at(3, i + 1), 1.5f});
    data.corners.push_back({at(4, 4), 0.7f});
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    for (const bool limit : {false, true}) {
        RefineOptions options{.limit = limit};
        options.rules.averaging_steps = 2;
        const RuleRefiner ours(mesh, *find_scheme("averaging"), 2, options),
            theirs(mesh, *find_scheme("catmull-clark"), 2, options);
        CHECK(most_apart(values(ours, mesh, false).positions, values(theirs, mesh, false).positions) < 1e-14);
    }
}

TEST_CASE("attributes of any width, and smoothing of the control points") {
    const ControlMesh mesh = model("cube");
    const RuleRefiner refiner(mesh, *find_scheme("kobbelt"), 2);
    std::vector<double> weights(mesh.vertex_count() * 5), out(refiner.vertex_count() * 5);
    for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = std::sin(double(i));
    refiner.refine(weights, 5, out);
    for (int k = 0; k < 5; ++k) {
        std::vector<double> one(mesh.vertex_count()), single(refiner.vertex_count());
        for (std::size_t v = 0; v < one.size(); ++v) one[v] = weights[5 * v + k];
        refiner.refine(one, 1, single);
        for (std::size_t v = 0; v < single.size(); ++v) REQUIRE(single[v] == out[5 * v + k]);
    }
    CHECK_THROWS_WITH_AS(refiner.refine(weights, 4, out), doctest::Contains("control values"), Error);
    CHECK_THROWS_AS(refiner.refine(weights, 0, out), Error);
    CHECK_THROWS_AS(refiner.refine(weights, 5, std::span(out).first(3)), Error);
    // A cube's corner and the mean of its three neighbours: two thirds of the way.
    const PolygonMesh smooth = refine(mesh, "kobbelt", 1, {.smoothing = 1});
    for (std::uint32_t v = 0; v < 8; ++v)
        CHECK(glm::length(smooth.positions[v] - (2.0 / 3) * mesh.position(VertexId(v))) < 1e-15);
}

TEST_CASE("one call refines attributes as it refines positions, for every scheme, holes included") {
    for (const bool hole : {false, true})
        for (const bool limit : {false, true})
            for (const SchemeInfo& scheme : scheme_table()) {
                CAPTURE(scheme.name);
                const ControlMesh mesh = fitting(scheme, ControlMesh::build(sheet(4, hole)));
                // Five numbers: y, x, z, 1 and x.
                VertexAttribute five{"five", 5, {}}, one{"one", 1, std::vector<float>(mesh.vertex_count(), 1.0f)};
                for (const Vec3d& p : mesh.positions())
                    for (const double x : {p.y, p.x, p.z, 1.0, p.x}) five.values.push_back(static_cast<float>(x));
                const VertexAttribute attributes[] = {five, one};
                const PolygonMesh fine = refine(mesh, scheme, 2, {.limit = limit, .attributes = attributes});
                REQUIRE(fine.attributes.size() == 2);
                const std::vector<float>& values = fine.attributes[0].values;
                REQUIRE(values.size() == 5 * fine.positions.size());
                REQUIRE(fine.attributes[1].values.size() == fine.positions.size());
                double most = 0;
                for (std::size_t v = 0; v < fine.positions.size(); ++v) {
                    const Vec3d& p = fine.positions[v];
                    const double expected[] = {p.y, p.x, p.z, 1, p.x};
                    for (int k = 0; k < 5; ++k) most = std::max(most, std::abs(values[5 * v + k] - expected[k]));
                    most = std::max(most, std::abs(fine.attributes[1].values[v] - 1.0));
                }
                CHECK(most < 1e-6);
            }
}

TEST_CASE("[bad-input] refine() names what is wrong") {
    const ControlMesh cube = model("cube");
    for (const std::string name : {"catmull-clark", "kobbelt"}) {
        const VertexAttribute shorter[] = {{"heat", 2, std::vector<float>(15)}}, none[] = {{"heat", 0, {}}};
        CHECK_THROWS_WITH_AS(refine(cube, name, 1, {.attributes = shorter}),
                             doctest::Contains("\"heat\" has 15 values, but 8 vertices with 2 each need 16"), Error);
        CHECK_THROWS_WITH_AS(refine(cube, name, 1, {.attributes = none}), doctest::Contains("heat"), Error);
    }
    CHECK_THROWS_WITH_AS(refine(cube, "dosabin", 1), doctest::Contains("did you mean doo-sabin?"), Error);
    CHECK_THROWS_WITH_AS(refine(cube, "nonsense", 1), doctest::Contains("modified-butterfly"), Error);
    CHECK_THROWS_WITH_AS(refine_stencils(cube, *find_scheme("loop"), 1), doctest::Contains("triangulate"), Error);
    CHECK_THROWS_AS(refine_stencils(cube, *find_scheme("sqrt3"), 1), Error);
    CHECK_THROWS_WITH_AS(refine(cube, "doo-sabin", 1, {.smoothing = -1}), doctest::Contains("smoothing"), Error);
    RefineOptions receding{.limit = true};
    receding.rules.averaging_boundary = AveragingBoundary::recede;
    CHECK_THROWS_WITH_AS(refine(ControlMesh::build(sheet(3, false)), "biquartic", 1, receding),
                         doctest::Contains("nothing of the limit surface is left"), Error);
    RefineOptions small;
    small.context.max_memory_bytes = 1 << 20;
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        const ControlMesh mesh = fitting(scheme, cube);
        CHECK_THROWS_AS(refine(mesh, scheme, -1), Error);
        CHECK_THROWS_WITH_AS(refine(mesh, scheme, 30), doctest::Contains("32-bit"), Error);
        CHECK_THROWS_WITH_AS(refine(mesh, scheme, 7, small), doctest::Contains("1 MiB"), Error);
    }
}

TEST_CASE("stencils count against the memory limit, and rows that are not wanted are left out") {
    const ControlMesh cube = model("cube");
    RefineOptions options;
    options.context.max_memory_bytes = 1 << 20;  // enough for the levels
    for (const char* scheme : {"catmull-clark", "4-8", "doo-sabin"}) {
        CAPTURE(scheme);
        const RuleRefiner refiner(cube, *find_scheme(scheme), 4, options);
        CHECK_THROWS_WITH_AS(refiner.stencils(), doctest::Contains("the stencils of"), Error);
        CHECK_THROWS_WITH_AS(refine_stencils(cube, *find_scheme(scheme), 4, options), doctest::Contains("1 MiB"),
                             Error);
        RefineOptions more = options;
        more.context.max_memory_bytes = 8 << 20;
        const RuleRefiner large(cube, *find_scheme(scheme), 4, more);
        const StencilTable all = large.stencils();
        CHECK(all == RuleRefiner(cube, *find_scheme(scheme), 4).stencils());
        std::vector<char> wanted(large.vertex_count(), 0);
        StencilTable expected;
        for (std::uint32_t v = 0; v < large.vertex_count(); v += 3) {
            wanted[v] = 1;
            expected.push(all.row(static_cast<int>(v)));
        }
        CHECK(large.stencils(wanted) == expected);
    }
}

TEST_CASE("triangle schemes cut the faces of other meshes, and give attributes to the vertices that this adds") {
    const ControlMesh cube =
        ControlMesh::build(parse_obj("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 0.9 0\nv 1 1.1 1\n"
                                     "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\nf 2 1 4 3\n",
                                     "test.obj"));
    // A vertex of two faces whose diagonals would all repeat edges: the second face becomes a fan around a vertex more.
    const ControlMesh pillow =
        ControlMesh::build(parse_obj("v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\n"
                                     "f 1 2 3\nf 1 3 4\nf 4 3 2 1\n",
                                     "test.obj"));
    for (const ControlMesh* mesh : {&cube, &pillow}) {
        VertexAttribute attribute{"position", 3, {}};
        for (const Vec3d& p : mesh->positions())
            for (int i = 0; i < 3; ++i) attribute.values.push_back(static_cast<float>(p[i]));
        const ControlMesh cut = triangulate(*mesh);
        CHECK(cut.face_count() > mesh->face_count());
        for (const SchemeInfo& scheme : scheme_table()) {
            if (scheme.family != MeshFamily::triangles) continue;
            CAPTURE(scheme.name);
            const PolygonMesh mine = refine(*mesh, scheme, 2, {.attributes = {&attribute, 1}});
            const PolygonMesh theirs = refine(cut, scheme, 2);
            CHECK(mine.positions == theirs.positions);
            CHECK(mine.face_vertices == theirs.face_vertices);
            REQUIRE(!mine.warnings.empty());
            CHECK(mine.warnings[0].find("triangles") != std::string::npos);
            REQUIRE(mine.attributes.size() == 1);
            for (std::size_t v = 0; v < mine.positions.size(); ++v)
                for (std::size_t i = 0; i < 3; ++i)
                    CHECK(mine.attributes[0].values[3 * v + i] ==
                          doctest::Approx(mine.positions[v][static_cast<int>(i)]).epsilon(1e-6));
        }
    }
}

TEST_CASE("kobbelt: Loop's tangent masks on the ring, a few levels down, point where the scheme's eigenvectors do") {
    // Zorin and Schroeder's advice for tangents (SIGGRAPH course 2000, 4.4), against the masks of the scheme itself.
    for (const std::uint64_t seed : test::seeds(3)) {
        test::RandomMeshOptions options = test::random_options(seed);
        options.topology = seed % 2 == 0 ? test::Topology::sphere : test::Topology::torus;
        options.removed_faces = 0;
        options.edge_vertices = options.hole = options.crease = options.corner = 0;
        const ControlMesh mesh = ControlMesh::build(test::random_mesh_data(seed, options));
        const auto largest_angle = [&](int levels) {
            const RuleRefiner refiner(mesh, *find_scheme("kobbelt"), levels, {.normals = true});
            std::vector<Vec3d> points(refiner.vertex_count()), normals(refiner.vertex_count());
            refiner.refine(mesh.positions(), points, normals);
            double most = 0;
            for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
                const RuleMesh::Ring ring = refiner.last().ring(static_cast<int>(v));
                Vec3d along(0), across(0);
                for (int i = 0; i < ring.edges(); ++i) {
                    const double turn = 2 * std::numbers::pi * i / ring.edges();
                    along += std::cos(turn) * points[static_cast<std::size_t>(ring.at(i))];
                    across += std::sin(turn) * points[static_cast<std::size_t>(ring.at(i))];
                }
                const Vec3d normal = glm::normalize(glm::cross(along, across));
                most = std::max(most, std::acos(std::clamp(glm::dot(normal, normals[v]), -1.0, 1.0)));
            }
            return most;
        };
        CAPTURE(seed);
        const double coarse = largest_angle(2), fine = largest_angle(5);
        CHECK(fine < 0.3 * coarse);
        CHECK(fine < 0.1);
    }
}

TEST_CASE("[bad-input] every scheme says that no face is left where all are holes") {
    ControlMeshData data;
    data.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    data.face_offsets = {0, 3, 6};
    data.face_vertices = {0, 1, 2, 0, 2, 3};
    data.holes = {0, 1};
    const ControlMesh mesh = ControlMesh::build(data);
    for (const SchemeInfo& scheme : scheme_table())
        for (const bool limit : {false, true}) {
            CAPTURE(scheme.name);
            CAPTURE(limit);
            const PolygonMesh result = refine(mesh, scheme, 2, {.limit = limit});
            CHECK(result.face_count() == 0);
            CHECK(std::ranges::count_if(result.warnings, [](const std::string& warning) {
                      return warning.find("no face is left") != std::string::npos;
                  }) == 1);
        }
}

TEST_SUITE_END();
