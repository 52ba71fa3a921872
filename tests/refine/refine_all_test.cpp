#include "../../hier/base/error.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../kit/corner_angle_mesh.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/nearest.hpp"
#include "../kit/random_mesh.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::mesh_for, test::model;

namespace {

/// A sheet that is not flat.
ControlMeshData sheet(std::uint32_t n) {
    ControlMeshData data = test::unit_sheet(n);
    for (std::uint32_t i = 0; i < data.positions.size(); ++i)
        data.positions[i].z = 0.1 * ((i % (n + 1) * 7 + i / (n + 1) * 3) % 5);
    // No corners, which the triangulated mesh would keep and its charts not.
    data.boundary_rule = BoundaryRule::edge_only;
    data.face_varying_rule = FaceVaryingRule::smooth_all;
    return data;
}

double most_apart(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    REQUIRE(a.size() == b.size());
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, glm::length(a[i] - b[i]));
    return most;
}

struct Values {
    std::vector<Vec3d> positions, normals;
};

Values values(const RuleRefiner& refiner, const ControlMesh& mesh, bool normals) {
    Values result{std::vector<Vec3d>(refiner.vertex_count()), {}};
    if (normals) result.normals.resize(refiner.vertex_count());
    refiner.refine(mesh.positions(), result.positions, result.normals);
    return result;
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

TEST_CASE(
    "[slow] limits of every scheme: from any level the same where vertices stay, and approached, creases included") {
    struct Input {
        std::string name;
        ControlMesh mesh;
        bool smooth = true;  ///< but for its boundary
    };
    std::vector<Input> inputs;
    for (const char* name : {"cube", "pipe3", "extruded_pentagon"}) inputs.push_back({name, model(name)});
    // A cube's edges, semi-sharp for long: a loop around a face, three in a corner, one that ends at both of its ends.
    for (const float scale : {1.3f, 4.5f}) {
        ControlMeshData data = test::model_data("cube");
        const std::vector<std::uint32_t>& f = data.face_vertices;
        for (std::uint32_t i = 0; i < 4; ++i) data.creases.push_back({f[i], f[(i + 1) % 4], scale * (1 + 0.3f * i)});
        data.creases.push_back({f[4], f[5], scale});
        data.creases.push_back({f[9], f[10], 0.5f * scale});
        inputs.push_back({"creased " + std::to_string(scale), ControlMesh::build(std::move(data)), false});
    }
    for (const auto& [name, input, smooth] : inputs)
        for (const SchemeInfo& scheme : scheme_table()) {
            CAPTURE(name);
            CAPTURE(scheme.name);
            const bool hexagons = scheme.family == MeshFamily::hexagons;
            const bool flat = scheme.name == "bilinear" || scheme.name == "midpoint";
            if (!smooth && (hexagons || flat)) continue;
            const ControlMesh mesh = mesh_for(scheme, input);
            const double size = mesh.bounding_box().diagonal();
            const bool normals = smooth && !hexagons && !flat;
            const RefineOptions options{.limit = true, .normals = normals};
            const RuleRefiner first(mesh, scheme, 1, options);
            const Values a = values(first, mesh, normals);
            if (scheme.lattice == FanLattice::dual && !hexagons) {
                const PolygonMesh deep = refine(mesh, scheme, smooth ? 4 : 6);
                const PointMatch in_deep(deep.positions);
                double most = 0;
                for (const Vec3d& p : a.positions)
                    most = std::max(most, glm::length(p - deep.positions[in_deep.nearest(p)]));
                CHECK(most < (smooth ? 0.04 : 0.01) * size);
                for (const Vec3d& n : a.normals) CHECK(glm::length(n) == doctest::Approx(1));
                continue;
            }
            const auto seen_from = [&](const Values& level) {
                return std::vector(level.positions.begin(), level.positions.begin() + first.vertex_count());
            };
            const Values b = values(RuleRefiner(mesh, scheme, 2, options), mesh, normals);
            CHECK(most_apart(a.positions, seen_from(b)) < 1e-11 * size);
            int differ = 0;  // corners have no normals of their own
            for (std::uint32_t v = 0; normals && v < first.vertex_count(); ++v)
                differ += first.last().rule(static_cast<int>(v)) != VertexRule::corner &&
                          glm::length(a.normals[v] - b.normals[v]) > 1e-9;
            CHECK(differ == 0);
            if (!smooth) continue;
            const Values deep = values(RuleRefiner(mesh, scheme, 3), mesh, false);
            CHECK(most_apart(a.positions, seen_from(deep)) < 0.04 * size);
        }
}

TEST_CASE("limits where boundaries recede: the part of the mesh that is on the surface") {
    const ControlMesh mesh = ControlMesh::build(sheet(6));
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
    ControlMeshData data = sheet(6);
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
    for (const char* scheme : {"kobbelt", "honeycomb"}) {
        std::vector<VertexAttribute> attributes(6);
        attributes[5].width = 5;
        for (std::uint32_t i = 0; i < 5 * mesh.vertex_count(); ++i) {
            attributes[5].values.push_back(static_cast<float>(std::sin(double(i))));
            attributes[i % 5].values.push_back(attributes[5].values.back());
        }
        const std::vector<VertexAttribute> out = refine(mesh, scheme, 2, {.attributes = attributes}).attributes;
        for (std::size_t i = 0; i < out[5].values.size(); ++i) REQUIRE(out[5].values[i] == out[i % 5].values[i / 5]);
    }
    // A cube's corner and the mean of its three neighbours: two thirds of the way.
    const PolygonMesh smooth = refine(mesh, "kobbelt", 1, {.smoothing = 1});
    for (std::uint32_t v = 0; v < 8; ++v)
        CHECK(glm::length(smooth.positions[v] - (2.0 / 3) * mesh.position(VertexId(v))) < 1e-15);
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
    CHECK_THROWS_WITH_AS(refine(ControlMesh::build(sheet(3)), "biquartic", 1, receding),
                         doctest::Contains("nothing of the limit surface is left"), Error);
    RefineOptions small;
    small.context.max_memory_bytes = 1 << 20;
    for (const SchemeInfo& scheme : scheme_table()) {
        CAPTURE(scheme.name);
        const ControlMesh mesh = mesh_for(scheme, cube);
        CHECK_THROWS_AS(refine(mesh, scheme, -1), Error);
        bool started = false;
        small.context.progress = [&](std::string_view, double) { return started = true; };
        CHECK_THROWS_WITH_AS(refine(mesh, scheme, 30, {.context = {.progress = small.context.progress}}),
                             doctest::Contains("32-bit"), Error);
        CHECK_THROWS_WITH_AS(refine(mesh, scheme, 7, small), doctest::Contains("1 MiB"), Error);
        CHECK_FALSE(started);
        RefineOptions cancelled;
        cancelled.context.progress = [](std::string_view, double fraction) { return fraction < 0.5; };
        CHECK_THROWS_AS(refine(mesh, scheme, 3, cancelled), Error);
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

TEST_CASE("faces beside boundaries that recede lie in their control faces") {
    constexpr std::uint32_t n = 8;
    ControlMeshData data = test::grid(n);
    for (std::uint32_t f = 0; f < n * n; ++f) {
        data.face_material.push_back(f);
        data.materials.push_back(std::to_string(f));
    }
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    for (int steps = 1; steps <= 5; ++steps)
        for (int levels = 1; levels <= 4; ++levels) {
            CAPTURE(steps);
            CAPTURE(levels);
            RefineOptions options;
            options.rules.averaging_steps = steps;
            options.rules.averaging_boundary = AveragingBoundary::recede;
            const SchemeInfo& scheme = *find_scheme("averaging");
            const PolygonMesh refined = refine(mesh, scheme, levels, options);
            REQUIRE(refined.face_count() > 0);
            int outside = 0;
            for (std::uint32_t f = 0; f < refined.face_count(); ++f) {
                Vec3d centre(0);
                for (std::uint32_t c = refined.face_offsets[f]; c < refined.face_offsets[f + 1]; ++c)
                    centre += 0.25 * refined.positions[refined.face_vertices[c]];
                const std::uint32_t in = refined.face_material[f];
                outside += std::max(std::abs(centre.x - in % n - 0.5), std::abs(centre.y - in / n - 0.5)) > 0.5 + 1e-9;
            }
            CHECK(outside == 0);
        }
}

TEST_CASE("limits beside a crease that bends at a vertex of regular valence are the same seen from any level") {
    // The sheet's crease that turns down leaves two triangles on one side of the bend and four on the other.
    ControlMeshData data = test::sheet(true).data();
    data.corners.clear();
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    const RefineOptions plain{.limit = true, .normals = true};
    RefineOptions hoppe = plain;
    hoppe.rules.hoppe_crease = true;
    const std::pair<std::string_view, RefineOptions> chosen[] = {
        {"loop", plain}, {"loop", hoppe}, {"tuned-loop", plain}, {"modified-butterfly", plain}};
    for (const auto& [name, options] : chosen) {
        CAPTURE(name);
        for (const auto& [early, late] : {std::pair(1, 2), {2, 4}}) {
            const PolygonMesh a = refine(mesh, *find_scheme(name), early, options),
                              b = refine(mesh, *find_scheme(name), late, options);
            const PointMatch in_b(b.positions), in_control(mesh.positions());
            double worst = 0, worst_normal = 0;
            for (std::size_t v = 0; v < a.positions.size(); ++v) {
                const std::uint32_t w = in_b.nearest(a.positions[v]);
                worst = std::max(worst, glm::length(a.positions[v] - b.positions[w]));
                // Corners stay where they are, and have the mean normal of their faces.
                const Vec3d& nearest = mesh.positions()[in_control.nearest(a.positions[v])];
                if (!options.rules.hoppe_crease && glm::length(a.positions[v] - nearest) > 1e-9)
                    worst_normal = std::max(worst_normal, glm::length(a.normals[v] - b.normals[w]));
            }
            CHECK(worst < 1e-12);
            CHECK(worst_normal < 1e-9);
        }
    }
}

TEST_CASE("refinement by repeated rows can be cancelled, charts as well") {
    ControlMeshData data = mesh_for(*find_scheme("butterfly"), ControlMesh::build(test::skewed_grid(3))).data();
    test::add_charts(data);
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    int calls = 0;
    RefineOptions options;
    options.context.progress = [&](std::string_view, double) { return ++calls > 0; };
    refine(mesh, "butterfly", 5, options);
    const int all = calls;
    CHECK(all > 4);
    for (int stop = 1; stop <= all; ++stop) {
        calls = 0;
        options.context.progress = [&](std::string_view, double) { return ++calls < stop; };
        CHECK_THROWS_AS(refine(mesh, "butterfly", 5, options), Error);
    }
}

TEST_SUITE_END();
