#include "../kit/point_match.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/refused_first.hpp"
#include "../kit/repeated_rows_helpers.hpp"

#include "../../hier/base/vec.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::Case, test::cases, test::farthest_apart, test::make_mesh, test::marks, test::mesh_of;

TEST_SUITE_BEGIN("refine");

TEST_CASE("faces beside boundaries that recede lie in their control faces") {
    constexpr std::uint32_t n = 8;
    ControlMeshData data;
    data.face_offsets = {0};
    for (std::uint32_t i = 0; i < (n + 1) * (n + 1); ++i) data.positions.emplace_back(i % (n + 1), i / (n + 1), 0);
    for (std::uint32_t f = 0; f < n * n; ++f) {
        const std::uint32_t first = f / n * (n + 1) + f % n;
        for (const std::uint32_t v : {first, first + 1, first + n + 2, first + n + 1}) data.face_vertices.push_back(v);
        data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
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
            for (const PolygonMesh& refined :
                 {refine(mesh, scheme, levels, options), refine_stencils(mesh, scheme, levels, options).mesh}) {
                REQUIRE(refined.face_count() > 0);
                int outside = 0;
                for (std::uint32_t f = 0; f < refined.face_count(); ++f) {
                    Vec3d centre(0);
                    for (std::uint32_t c = refined.face_offsets[f]; c < refined.face_offsets[f + 1]; ++c)
                        centre += 0.25 * refined.positions[refined.face_vertices[c]];
                    const std::uint32_t in = refined.face_material[f];
                    outside +=
                        std::max(std::abs(centre.x - in % n - 0.5), std::abs(centre.y - in / n - 0.5)) > 0.5 + 1e-9;
                }
                CHECK(outside == 0);
            }
        }
}

TEST_CASE("tags of dual schemes that run out late: holes, materials, attributes, limits and normals as by the rules") {
    constexpr std::uint32_t n = 8;
    ControlMeshData data = test::skewed_grid(n);
    for (std::uint32_t x = 0; x < n; ++x)
        data.creases.push_back({3 * (n + 1) + x, 3 * (n + 1) + x + 1, x < n / 2 ? 3.5f : 4.5f});
    for (std::uint32_t y = 1; y < 5; ++y) data.creases.push_back({y * (n + 1) + 5, (y + 1) * (n + 1) + 5, 3.2f});
    data.corners.push_back({3 * (n + 1) + 2, 3.7f});
    data.holes.push_back(3 * n + 1);
    data.materials = {"a", "b", "c"};
    for (std::uint32_t f = 0; f < n * n; ++f) data.face_material.push_back(f * 2654435761u >> 9 & 1);
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    std::vector<float> xyz;
    for (const Vec3d& p : mesh.positions())
        for (int i = 0; i < 3; ++i) xyz.push_back(static_cast<float>(p[i]));
    const VertexAttribute attribute{"xyz", 3, xyz};
    for (const char* scheme : {"doo-sabin", "midedge-simplest"})
        for (const bool limit : {false, true}) {
            if (limit && scheme_named(scheme).name != "doo-sabin") continue;
            CAPTURE(scheme);
            CAPTURE(limit);
            const RefineOptions options{.limit = limit, .normals = limit, .attributes = {&attribute, 1}};
            const PolygonMesh ours = refine(mesh, scheme, 5, options),
                              expected = refine_stencils(mesh, scheme_named(scheme), 5, options).mesh;
            REQUIRE(ours.positions.size() == expected.positions.size());
            REQUIRE(ours.face_count() == expected.face_count());
            CHECK(farthest_apart(ours.positions, expected.positions) < 1e-11);
            CHECK(farthest_apart(marks(ours, false), marks(expected, false)) < 1e-9);
            CHECK(std::ranges::count(ours.face_material, 1) == std::ranges::count(expected.face_material, 1));
            double worst = 0;
            for (std::size_t v = 0; v < ours.positions.size(); ++v)
                for (int i = 0; i < 3; ++i)
                    worst = std::max(worst, std::abs(ours.attributes[0].values[3 * v + i] - ours.positions[v][i]));
            CHECK(worst < 1e-4);
            std::vector<Vec3d> with_normals = ours.positions, expected_with = expected.positions;
            for (std::size_t v = 0; v < ours.normals.size(); ++v) {
                with_normals[v] += ours.normals[v];
                expected_with[v] += expected.normals[v];
            }
            CHECK(farthest_apart(with_normals, expected_with) < 1e-7);
        }
}

TEST_CASE("limits on Hoppe's creases are the same seen from any level, however many faces each side has") {
    RefineOptions options{.limit = true};
    options.rules.hoppe_crease = true;
    // An octahedron with creases around one face: one face on one side of each vertex, three on the other.
    ControlMeshData data;
    data.positions = {{1, 0, 0}, {0, 1.2, 0}, {0, 0, 0.8}, {-1.1, 0, 0}, {0, -0.9, 0}, {0, 0, -1}};
    data.face_vertices = {4, 0, 2, 0, 1, 2, 1, 3, 2, 3, 4, 2, 1, 0, 5, 3, 1, 5, 4, 3, 5, 0, 4, 5};
    for (std::uint32_t f = 0; f <= 8; ++f) data.face_offsets.push_back(3 * f);
    for (std::uint32_t v = 0; v < 3; ++v) data.creases.push_back({v, (v + 1) % 3, k_sharpness_infinity});
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    const SchemeInfo& loop = *find_scheme("loop");
    // Control vertices keep their numbers.
    const auto early = refine_stencils(mesh, loop, 1, options).mesh.positions,
               net = refine_stencils(mesh, loop, 5, {.rules = options.rules}).mesh.positions,
               late = refine_stencils(mesh, loop, 5, options).mesh.positions;
    for (std::size_t v = 0; v < 3; ++v) {
        CHECK(glm::length(early[v] - late[v]) < 1e-12);
        CHECK(glm::length(net[v] - late[v]) < 5e-3);
    }
}

TEST_CASE("limits beside a crease that bends at a vertex of regular valence are the same seen from any level") {
    // A triangular lattice whose crease leaves two faces on one side of the middle, four on the other.
    constexpr std::uint32_t n = 7, middle = n / 2;
    const auto at = [](std::uint32_t x, std::uint32_t y) { return y * n + x; };
    ControlMeshData data;
    data.face_offsets = {0};
    for (std::uint32_t y = 0; y < n; ++y)
        for (std::uint32_t x = 0; x < n; ++x)
            data.positions.emplace_back(x + 0.5 * y + 0.1 * std::sin(7.0 * at(x, y)), 0.8 * y,
                                        std::cos(5.0 * at(x, y)));
    for (std::uint32_t y = 0; y + 1 < n; ++y)
        for (std::uint32_t x = 0; x + 1 < n; ++x)
            for (const auto& face : {std::array{at(x, y), at(x + 1, y), at(x, y + 1)},
                                     std::array{at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)}}) {
                data.face_vertices.insert(data.face_vertices.end(), face.begin(), face.end());
                data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
            }
    for (std::uint32_t i = 0; i < middle; ++i) {
        data.creases.push_back({at(i, middle), at(i + 1, middle), k_sharpness_infinity});
        data.creases.push_back({at(middle, middle + i), at(middle, middle + i + 1), k_sharpness_infinity});
    }
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

TEST_CASE("[slow] seams over inner vertices of two faces: texture coordinates by rows are those of the rules") {
    int seams = 0, missing = 0;
    for (const char* name : {"doo-sabin", "midedge", "biquartic"})
        for (const std::uint64_t seed : test::seeds(8)) {
            CAPTURE(name);
            CAPTURE(seed);
            test::RandomMeshOptions random = test::random_options(seed);
            random.columns = random.rows = 3;
            random.hole = random.corner = 0;
            random.crease = seed % 4 == 3 ? 0.1 : 0.0;
            random.edge_vertices = 0.2;
            random.boundary_rule = BoundaryRule::edge_only;
            ControlMeshData data = test::random_mesh_data(seed, random);
            for (auto& crease : data.creases) crease.sharpness = k_sharpness_infinity;
            test::add_charts(data);
            if (seed % 2 == 0) {
                // Every face a chart of its own.
                data.uvs.clear();
                data.face_uvs.clear();
                for (std::uint32_t f = 0; f + 1 < data.face_offsets.size(); ++f)
                    for (std::uint32_t c = data.face_offsets[f]; c < data.face_offsets[f + 1]; ++c) {
                        data.face_uvs.push_back(c);
                        const Vec3d& p = data.positions[data.face_vertices[c]];
                        data.uvs.emplace_back(p.x + 10.0 * f, p.y + 0.5 * p.z);
                    }
            }
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            const SchemeInfo& scheme = *find_scheme(name);
            bool valence2 = false;
            for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v)
                valence2 = valence2 || (!mesh.is_boundary(VertexId(v)) && mesh.face_valence(VertexId(v)) == 2);
            if (!valence2) continue;
            ++seams;
            constexpr int k_levels = 4;
            const PolygonMesh ours = refine(mesh, scheme, k_levels);
            const PolygonMesh expected = refine_stencils(mesh, scheme, k_levels).mesh;
            if (ours.uvs.empty() || expected.uvs.empty()) {  // a crease that ends at a seam
                ++missing;
                continue;
            }
            REQUIRE(ours.face_count() == expected.face_count());
            CHECK(farthest_apart(marks(ours, true), marks(expected, true)) < 1e-7);
        }
    CHECK(seams > 10);
    CHECK(missing < 3);
}

TEST_CASE("too many levels and too little memory are refused before the first one is made, with or without a limit") {
    const ControlMesh mesh = make_mesh(3, false, false, true);
    const auto code = [&](int levels, std::uint64_t limit) { return test::refused_first(mesh, "4-8", levels, limit); };
    CHECK(code(20, 0) == ErrorCode::unsupported);
    CHECK(code(40, 0) == ErrorCode::unsupported);
    CHECK(code(9, std::uint64_t{64} << 20) == ErrorCode::memory_limit);
    CHECK(code(5, std::uint64_t{1} << 30) == std::nullopt);
}

TEST_CASE("refinement by repeated rows can be cancelled, charts as well") {
    const ControlMesh mesh = make_mesh(3, true, false, true);
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
