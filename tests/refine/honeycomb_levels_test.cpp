#include "../kit/random_mesh.hpp"
#include "../kit/refused_first.hpp"
#include "../kit/same_bytes.hpp"

#include "../../hier/base/error.hpp"
#include "../../refine/uniform/position_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

enum class Tags { none, for_ever, for_some_levels, darts };

/// N-gons, boundaries, vertices of two edges; two charts, three materials and a hole.
ControlMesh make_mesh(std::uint64_t seed, Tags tags, bool with_uvs) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = 4;
    options.rows = 3;
    ControlMeshData data = test::random_mesh_data(seed, options);
    if (tags == Tags::none) {
        data.creases.clear();
        data.corners.clear();
    }
    for (auto& crease : data.creases)
        crease.sharpness = tags == Tags::for_ever ? k_sharpness_infinity : 0.5f + static_cast<float>(seed % 3);
    for (auto& corner : data.corners) corner.sharpness = tags == Tags::for_ever ? k_sharpness_infinity : 1.5f;
    const ControlMesh plain = ControlMesh::build(data);
    if (tags == Tags::darts)
        for (std::uint32_t h = 0; h < plain.halfedge_count(); h += 5)
            if (plain.twin(HalfedgeId(h)).valid())
                data.creases.push_back(
                    {plain.origin(HalfedgeId(h)).value, plain.target(HalfedgeId(h)).value, k_sharpness_infinity});
    data.materials = {"a", "b", "c"};
    for (std::uint32_t f = 0; f < plain.face_count(); ++f) data.face_material.push_back(7 * f % 3);
    if (seed % 3 == 0) data.holes = {static_cast<std::uint32_t>(seed) % plain.face_count()};
    if (with_uvs) {
        const auto count = static_cast<std::uint32_t>(data.positions.size());
        for (const double shift : {0.0, 100.0})
            for (const Vec3d& p : data.positions) data.uvs.emplace_back(p.x + shift, p.y + 0.5 * p.z);
        for (std::uint32_t f = 0; f < plain.face_count(); ++f)
            for (std::uint32_t c = data.face_offsets[f]; c < data.face_offsets[f + 1]; ++c)
                data.face_uvs.push_back(data.face_vertices[c] + (f % 3 == 2 ? count : 0));
    }
    return ControlMesh::build(std::move(data));
}

double distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, glm::length(a[i] - b[i]));
    return most;
}

/// By arithmetic and by rules: the same faces in the same order.
void check_against_rules(const ControlMesh& mesh, int levels, const RefineOptions& options) {
    const PolygonMesh ours = refine(mesh, "honeycomb", levels, options),
                      expected = refine_stencils(mesh, scheme_named("honeycomb"), levels, options).mesh;
    REQUIRE(ours.positions.size() == expected.positions.size());
    REQUIRE(ours.normals.size() == expected.normals.size());
    CHECK(ours.face_offsets == expected.face_offsets);
    CHECK(ours.face_vertices == expected.face_vertices);
    CHECK(ours.face_material == expected.face_material);
    CHECK(ours.face_uvs == expected.face_uvs);
    CHECK(ours.warnings == expected.warnings);
    CHECK(distance(ours.positions, expected.positions) < 1e-12);
    CHECK(distance(ours.normals, expected.normals) < 1e-9);
    REQUIRE(ours.uvs.size() == expected.uvs.size());
    for (std::size_t i = 0; i < ours.uvs.size(); ++i) CHECK(glm::length(ours.uvs[i] - expected.uvs[i]) < 1e-10);
    for (std::size_t i = 0; i < ours.attributes.size(); ++i)
        for (std::size_t k = 0; k < ours.attributes[i].values.size(); ++k)
            CHECK(ours.attributes[i].values[k] == doctest::Approx(expected.attributes[i].values[k]).epsilon(1e-6));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("honeycomb refinement by arithmetic gives the vertices and faces of the rules, number by number") {
    for (const std::uint64_t seed : test::seeds(6))
        for (const Tags tags : {Tags::none, Tags::for_ever, Tags::for_some_levels, Tags::darts})
            for (const bool with_uvs : {false, true}) {
                CAPTURE(seed);
                CAPTURE(static_cast<int>(tags));
                CAPTURE(with_uvs);
                const ControlMesh mesh = make_mesh(seed, tags, with_uvs);
                std::vector<float> values;
                for (const Vec3d& p : mesh.positions()) values.push_back(static_cast<float>(p.x - 2 * p.z));
                const VertexAttribute attribute{"mixed", 1, values};
                RefineOptions options;
                if (seed % 2 == 0) options.attributes = {&attribute, 1};
                options.smoothing = seed % 4 == 3 ? 1 : 0;
                for (int levels = 1; levels <= 3; ++levels) {
                    CAPTURE(levels);
                    REQUIRE_NOTHROW(check_against_rules(mesh, levels, options));
                }
            }
}

TEST_CASE("limits and normals of honeycomb refinement by arithmetic are those of the rules") {
    for (const std::uint64_t seed : test::seeds(5))
        for (const Tags tags : {Tags::none, Tags::for_ever, Tags::for_some_levels})
            for (int levels = 1; levels <= 3; ++levels) {
                CAPTURE(seed);
                CAPTURE(static_cast<int>(tags));
                CAPTURE(levels);
                const ControlMesh mesh = make_mesh(seed, tags, false);
                const RefineOptions options{.limit = true, .normals = true};
                std::string refused;
                try {
                    refine_stencils(mesh, scheme_named("honeycomb"), levels, options);
                } catch (const Error& e) {
                    refused = e.what();
                }
                // Where a crease ends there is no limit: in the same words.
                if (!refused.empty())
                    CHECK_THROWS_WITH_AS(refine(mesh, "honeycomb", levels, options), refused.c_str(), Error);
                else
                    check_against_rules(mesh, levels, options);
            }
}

TEST_CASE("honeycomb refinement leaves vertices without faces where they are, tags and all") {
    ControlMeshData data = make_mesh(4, Tags::none, false).data();
    data.positions.emplace_back(5, 5, 5);
    data.positions.emplace_back(6, 5, 5);
    data.corners.push_back({static_cast<std::uint32_t>(data.positions.size()) - 2, 1.5f});
    data.corners.push_back({0, 2.5f});
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    for (int levels = 1; levels <= 3; ++levels) check_against_rules(mesh, levels, {.limit = true, .normals = true});
}

TEST_CASE("limits of honeycomb refinement that do not exist are refused before any level is made") {
    ControlMeshData data = make_mesh(1, Tags::none, false).data();
    const ControlMesh plain = ControlMesh::build(data);
    std::uint32_t h = 0;
    const auto is_inside = [&](VertexId v) { return !plain.is_boundary(v); };
    while (!(is_inside(plain.origin(HalfedgeId(h))) && is_inside(plain.target(HalfedgeId(h))))) ++h;
    data.creases.push_back(
        {plain.origin(HalfedgeId(h)).value, plain.target(HalfedgeId(h)).value, k_sharpness_infinity});
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    bool started = false;
    RefineOptions options{.limit = true};
    options.context.progress = [&](std::string_view, double) { return started = true; };
    try {
        refine(mesh, "honeycomb", 7, options);
        FAIL("accepted");
    } catch (const Error& e) {
        CHECK(e.code() == ErrorCode::unsupported);
        CHECK(std::string_view(e.what()).find("a crease that ends there") != std::string_view::npos);
    }
    CHECK(!started);
    // Normals alone are those of the faces, by arithmetic and by rules.
    check_against_rules(mesh, 2, {.normals = true});
}

TEST_CASE("[inv10] honeycomb refinement: the same bytes for any number of threads, and for positions again") {
    const ControlMesh mesh = make_mesh(1, Tags::none, true);
    RefineOptions options{.limit = true, .normals = true};
    options.context.threads = 1;
    const PolygonMesh one = refine(mesh, "honeycomb", 5, options);
    for (const int threads : {2, 4}) {
        options.context.threads = threads;
        const PolygonMesh many = refine(mesh, "honeycomb", 5, options);
        CHECK(test::same_bytes(one.positions, many.positions));
        CHECK(test::same_bytes(one.normals, many.normals));
        CHECK(test::same_bytes(one.uvs, many.uvs));
        CHECK(one.face_vertices == many.face_vertices);
        CHECK(one.face_uvs == many.face_uvs);
        const PositionRefiner refiner(mesh, "honeycomb", 5, options);
        std::vector<Vec3d> again(one.positions.size()), normals(one.positions.size());
        refiner.refine(mesh.positions(), again, normals);
        CHECK(test::same_bytes(one.positions, again));
        CHECK(test::same_bytes(one.normals, normals));
    }
}

TEST_CASE("honeycomb refinement refuses what cannot be counted or held, before it makes any of it") {
    const ControlMesh mesh = make_mesh(2, Tags::none, false);
    const auto code = [&](int levels, std::uint64_t limit) {
        return test::refused_first(mesh, "honeycomb", levels, limit);
    };
    CHECK(code(14, 0) == ErrorCode::unsupported);
    CHECK(code(10, 1 << 20) == ErrorCode::memory_limit);
    CHECK(code(2, 1 << 20) == std::nullopt);
    // Every face a chart of its own, which goes on beyond its seams: more than there is of the mesh.
    ControlMeshData data = mesh.data();
    for (const std::uint32_t v : data.face_vertices) {
        data.face_uvs.push_back(static_cast<std::uint32_t>(data.uvs.size()));
        data.uvs.emplace_back(data.positions[v].x, data.positions[v].y);
    }
    const ControlMesh torn = ControlMesh::build(std::move(data));
    RefineOptions options;
    options.context.max_memory_bytes = 4 << 20;
    CHECK_NOTHROW(refine(mesh, "honeycomb", 5, options));
    CHECK_THROWS_AS(refine(torn, "honeycomb", 5, options), Error);
}

TEST_SUITE_END();
