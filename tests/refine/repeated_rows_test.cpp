#include "../kit/point_match.hpp"
#include "../kit/random_mesh.hpp"
#include "../kit/refused_first.hpp"
#include "../kit/repeated_rows_helpers.hpp"

#include "../../hier/base/vec.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"
#include "../../refine/uniform/repeated_rows.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

using namespace tetrakis;
using test::Case, test::cases, test::farthest_apart, test::make_mesh, test::marks, test::mesh_of;

namespace {

/// Creases around regions of faces, of which none ends at a dart, or along edges here and there, of which most do.
ControlMesh with_creases(const ControlMesh& mesh, std::uint64_t seed, bool with_limit, bool darts = false) {
    ControlMeshData data = mesh.data();
    const auto region = [&](HalfedgeId h) {
        const std::uint32_t f = mesh.face(h).value;
        return (f * 2654435761u + seed * 40503u) >> 7 & 3;
    };
    for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
        const HalfedgeId h(i), t = mesh.twin(h);
        if (!t.valid() || t.value < i) continue;
        const bool chosen = ((i * 2654435761u + seed * 7919u) >> 9) % 5 == 0;
        if (darts ? !chosen : region(h) == region(t)) continue;
        // Sharp beyond the last level is as sharp as for ever; but not for limits.
        const bool finite = !with_limit && i % 3 == 0;
        data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, finite ? 8.5f : k_sharpness_infinity});
    }
    data.corners.push_back({static_cast<std::uint32_t>(seed) % mesh.vertex_count(), k_sharpness_infinity});
    return ControlMesh::build(std::move(data));
}

std::unique_ptr<detail::RepeatedRows> rows_of(const ControlMesh& mesh, const Case& c, const RunContext& context = {}) {
    const SchemeInfo& scheme = *find_scheme(c.scheme);
    auto levels = std::make_unique<detail::RuleLevels>(mesh, scheme, c.rules, 0);
    return detail::RepeatedRows::make(mesh, scheme, c.levels, c.rules, levels, {.even_if_slower = true}, context);
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] [slow] rows that repeat themselves give what the rules give, point by point and face by face") {
    for (const Case& c : cases()) {
        CAPTURE(c.scheme);
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        const bool triangles = scheme.family == MeshFamily::triangles;
        int repeated = 0;
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(seed, triangles, seed % 2 == 1);
            const auto rows = rows_of(mesh, c);
            if (!rows) continue;
            ++repeated;
            const RefineOptions options{.rules = c.rules};
            const RuleRefiner by_rules(mesh, scheme, c.levels, options);
            const double size = bounding_box(mesh.positions()).diagonal();
            PolygonMesh ours;
            ours.positions.resize(rows->point_count());
            rows->refine(mesh.positions(), ours.positions, {}, {});
            std::vector<Vec3d> points(by_rules.vertex_count());
            by_rules.refine(mesh.positions(), points);
            const PolygonMesh expected = mesh_of(by_rules, points);
            CHECK(farthest_apart(ours.positions, expected.positions) < 1e-12 * size);

            detail::RepeatedRows::Faces faces = rows->faces({});
            ours.face_offsets = std::move(faces.offsets);
            ours.face_vertices = std::move(faces.vertices);
            CHECK(farthest_apart(marks(ours, false), marks(expected, false)) < 1e-11 * (size + size * size));
            // Control faces: as many faces each as by the rules.
            std::vector<int> cells(mesh.face_count(), 0);
            for (std::uint32_t f = 0; f < by_rules.face_count(); ++f) --cells[by_rules.control_face(f)];
            for (const std::uint32_t f : faces.control) ++cells[f];
            CHECK(std::ranges::count(cells, 0) == static_cast<std::ptrdiff_t>(cells.size()));
        }
        CHECK(repeated > 0);
    }
}

TEST_CASE(
    "[inv10] rows that repeat themselves give the same bytes for any number of threads, and for a refiner used again") {
    for (const Case& c : cases()) {
        CAPTURE(c.scheme);
        const ControlMesh mesh = make_mesh(4, find_scheme(c.scheme)->family == MeshFamily::triangles, false);
        const auto rows = rows_of(mesh, c);
        if (!rows) continue;
        std::vector<Vec3d> first;
        for (const int threads : {1, 2, 4, 1}) {
            RunContext context;
            context.threads = threads;
            std::vector<Vec3d> points(rows->point_count(), Vec3d(threads));
            with_threads(context, [&] { rows->refine(mesh.positions(), points, {}, context); });
            if (first.empty()) first = points;
            CHECK(std::memcmp(points.data(), first.data(), points.size() * sizeof(Vec3d)) == 0);
        }
    }
}

TEST_CASE("[slow] refine() by rows that repeat themselves: texture coordinates, attributes, holes as by the rules") {
    for (const Case& c : cases()) {
        CAPTURE(c.scheme);
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        const bool triangles = scheme.family == MeshFamily::triangles;
        for (const std::uint64_t seed : test::seeds(8)) {
            CAPTURE(seed);
            ControlMesh mesh = make_mesh(seed, triangles, seed % 2 == 1, true);
            if (seed >= 6 && fan_lattice(scheme, c.rules) == FanLattice::dual)
                mesh = with_creases(mesh, seed, true, seed == 7);
            // An attribute that is the position: the same masks give the same numbers.
            VertexAttribute attribute{"p", 3, {}};
            for (const Vec3d& p : mesh.positions())
                for (int i = 0; i < 3; ++i) attribute.values.push_back(static_cast<float>(p[i]));
            RefineOptions options{.rules = c.rules, .limit = seed == 1, .normals = seed == 1};
            options.attributes = {&attribute, 1};
            const PolygonMesh ours = refine(mesh, scheme, c.levels, options);
            // Stencils are always made by the rules.
            const PolygonMesh expected = refine_stencils(mesh, scheme, c.levels, options).mesh;
            const double size = bounding_box(mesh.positions()).diagonal();
            REQUIRE(ours.face_count() == expected.face_count());
            CHECK(farthest_apart(ours.positions, expected.positions) < 1e-12 * size);
            CHECK(farthest_apart(marks(ours, false), marks(expected, false)) < 1e-11 * (size + size * size));
            REQUIRE(ours.face_uvs.size() == expected.face_uvs.size());
            CHECK(ours.uvs.size() == expected.uvs.size());
            CHECK(farthest_apart(marks(ours, true), marks(expected, true)) < 1e-11 * (100 + size) * (100 + size));
            REQUIRE(ours.attributes.size() == 1);
            double worst = 0;
            for (std::size_t v = 0; v < ours.positions.size(); ++v)
                for (int i = 0; i < 3; ++i)
                    worst = std::max(worst, std::abs(ours.attributes[0].values[3 * v + i] - ours.positions[v][i]));
            CHECK(worst < 1e-5 * size);
            CHECK(ours.face_material == expected.face_material);
        }
    }
}

TEST_CASE("[slow] creases of dual schemes by rows that repeat themselves are those of the rules") {
    for (const Case& c : cases()) {
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        if (fan_lattice(scheme, c.rules) != FanLattice::dual) continue;
        CAPTURE(c.scheme);
        int repeated = 0;
        double worst = 0;  // of points with their normals
        for (const std::uint64_t seed : test::seeds(12)) {
            CAPTURE(seed);
            const bool limit = seed % 2 == 0;
            const ControlMesh mesh =
                with_creases(make_mesh(3 * (seed % 3) + seed % 2, false, false), seed, limit, seed % 12 >= 6);
            auto levels = std::make_unique<detail::RuleLevels>(mesh, scheme, c.rules, 0);
            detail::RepeatedRows::Demand demand;
            demand.limit = demand.normals = limit;
            demand.even_if_slower = true;
            const auto rows = detail::RepeatedRows::make(mesh, scheme, c.levels, c.rules, levels, demand, {});
            if (!rows) continue;
            ++repeated;
            const RefineOptions options{.rules = c.rules, .limit = limit, .normals = limit};
            const RuleRefiner by_rules(mesh, scheme, c.levels, options);
            REQUIRE(rows->point_count() == by_rules.vertex_count());
            std::vector<Vec3d> points(rows->point_count()), normals(limit ? points.size() : 0), expected(points.size()),
                expected_normals(normals.size());
            rows->refine(mesh.positions(), points, normals, {});
            by_rules.refine(mesh.positions(), expected);
            const double size = bounding_box(mesh.positions()).diagonal();
            CHECK(farthest_apart(points, expected) < 1e-12 * size);
            PolygonMesh ours;
            detail::RepeatedRows::Faces faces = rows->faces({});
            ours.positions = points;
            ours.face_offsets = std::move(faces.offsets);
            ours.face_vertices = std::move(faces.vertices);
            CHECK(farthest_apart(marks(ours, false), marks(mesh_of(by_rules, expected), false)) <
                  1e-11 * (size + size * size));
            std::vector<int> cells(mesh.face_count(), 0);
            for (std::uint32_t f = 0; f < by_rules.face_count(); ++f) --cells[by_rules.control_face(f)];
            for (const std::uint32_t f : faces.control) ++cells[f];
            CHECK(std::ranges::count(cells, 0) == static_cast<std::ptrdiff_t>(cells.size()));
            if (!limit) continue;
            by_rules.normals(mesh.positions(), expected_normals);
            for (std::size_t i = 0; i < points.size(); ++i) points[i] += normals[i];
            const PointMatch with_normals(points);
            std::vector<Vec3d> net(expected.size());
            RuleRefiner(mesh, scheme, c.levels, {.rules = c.rules}).refine(mesh.positions(), net);
            for (std::size_t i = 0; i < expected.size(); ++i) {
                // Where a mesh is folded together, both sides of a crease on one another, rounding has the last word.
                Vec3d sum(0);
                for (const int h : by_rules.last().ring(static_cast<int>(i)).halfedge)
                    sum += unit_or_zero(glm::cross(net[by_rules.last().target(h)] - net[i],
                                                   net[by_rules.last().origin(by_rules.last().prev(h))] - net[i]));
                if (glm::length(sum) < 0.5) continue;
                const Vec3d at = expected[i] + expected_normals[i];
                worst = std::max(worst, glm::length(at - points[with_normals.nearest(at)]));
            }
        }
        CHECK(repeated >= 12);
        CHECK(worst < 1e-7);
    }
}

TEST_CASE(
    "[slow] boundaries that recede leave the points and faces that the rules leave, and by limits and normals no "
    "fewer") {
    for (const std::uint64_t seed : test::seeds(5))
        for (int steps = 1; steps <= 4; ++steps) {
            CAPTURE(seed);
            CAPTURE(steps);
            const int levels = seed % 4 == 0 ? 4 : 3;
            test::RandomMeshOptions random = test::random_options(seed);
            random.columns = random.rows = 6;
            random.removed_faces = 0.05;
            const ControlMesh mesh = ControlMesh::build(test::random_mesh_data(seed, random));
            VertexAttribute attribute{"x", 1, {}};
            for (const Vec3d& p : mesh.positions()) attribute.values.push_back(static_cast<float>(p.x));
            RefineOptions options{.limit = seed % 3 == 0, .normals = seed % 6 == 1, .attributes = {&attribute, 1}};
            options.rules.averaging_steps = steps;
            options.rules.averaging_boundary = AveragingBoundary::recede;
            const SchemeInfo& scheme = *find_scheme("averaging");
            const std::optional<PolygonMesh> expected = test::by_stencils(mesh, scheme, levels, options);
            if (!expected) continue;
            const PolygonMesh ours = refine(mesh, scheme, levels, options);
            const double size = bounding_box(mesh.positions()).diagonal();
            CHECK(ours.positions.size() >= expected->positions.size());
            const PointMatch in_ours(ours.positions);
            double worst = 0;
            for (const Vec3d& p : expected->positions)
                worst = std::max(worst, glm::length(p - ours.positions[in_ours.nearest(p)]));
            CHECK(worst < 1e-12 * size);
            CHECK(ours.attributes[0].values.size() == ours.positions.size());
            if (options.limit || options.normals) continue;
            CHECK(ours.positions.size() == expected->positions.size());
            REQUIRE(ours.face_count() == expected->face_count());
            CHECK(farthest_apart(marks(ours, false), marks(*expected, false)) < 1e-11 * (size + size * size));
            for (std::size_t v = 0; v < ours.positions.size(); ++v)
                CHECK(std::abs(ours.attributes[0].values[v] - ours.positions[v].x) < 1e-5 * size);
        }
}

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

TEST_CASE("hundreds of edges around a vertex and around a face: rows that repeat themselves are those of the rules") {
    constexpr std::uint32_t k_edges = 260;
    for (const Case& c : {Case{"doo-sabin", 3}, Case{"tuned-loop", 3}, Case{"4-8", 3}}) {
        CAPTURE(c.scheme);
        ControlMeshData data;
        data.face_offsets = {0};
        const auto face = [&](std::initializer_list<std::uint32_t> vertices) {
            data.face_vertices.insert(data.face_vertices.end(), vertices);
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        };
        for (std::uint32_t i = 0; i < k_edges; ++i) {
            const double angle = 2 * std::numbers::pi * i / k_edges, r = 1 + 0.1 * std::sin(5 * angle);
            data.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), 0.1 * std::cos(3 * angle));
        }
        data.positions.emplace_back(0, 0, 1);
        for (std::uint32_t i = 0; i < k_edges; ++i) face({i, (i + 1) % k_edges, k_edges});
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        if (scheme.family == MeshFamily::triangles) {
            data.positions.emplace_back(0, 0, -1);
            for (std::uint32_t i = 0; i < k_edges; ++i) face({(i + 1) % k_edges, i, k_edges + 1});
        } else {
            for (std::uint32_t i = k_edges; i-- > 0;) data.face_vertices.push_back(i);
            data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
        }
        const ControlMesh mesh = ControlMesh::build(std::move(data));
        const auto rows = rows_of(mesh, c);
        REQUIRE(rows);
        const RuleRefiner by_rules(mesh, scheme, c.levels, {});
        std::vector<Vec3d> ours(rows->point_count()), expected(by_rules.vertex_count());
        rows->refine(mesh.positions(), ours, {}, {});
        by_rules.refine(mesh.positions(), expected);
        CHECK(farthest_apart(ours, expected) < 1e-12);
    }
}

TEST_CASE("semi-sharp tags of dual schemes leave the mesh that the rules leave") {
    // A grid with a line of creases across it, or a tagged corner on its boundary.
    constexpr std::uint32_t n = 6;
    for (const bool crease : {true, false})
        for (const float sharpness : {1.0f, 1.5f, 2.0f, 2.5f, 4.5f}) {
            ControlMeshData data = test::skewed_grid(n);
            for (std::uint32_t x = 0; crease && x < n; ++x)
                data.creases.push_back({3 * (n + 1) + x, 3 * (n + 1) + x + 1, sharpness});
            if (!crease) data.corners.push_back({3, sharpness});
            const ControlMesh mesh = ControlMesh::build(std::move(data));
            for (const char* scheme : {"doo-sabin", "midedge", "biquartic"}) {
                CAPTURE(scheme);
                CAPTURE(sharpness);
                const PolygonMesh ours = refine(mesh, scheme, 4),
                                  expected = refine_stencils(mesh, *find_scheme(scheme), 4).mesh;
                REQUIRE(ours.positions.size() == expected.positions.size());
                CHECK(ours.face_count() == expected.face_count());
                CHECK(farthest_apart(ours.positions, expected.positions) < 1e-11);
            }
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

TEST_CASE("two averaging steps that recede know no creases where a mesh is closed") {
    const ControlMesh torus = make_mesh(3, false, false);
    ControlMeshData data = torus.data();
    for (std::uint32_t h = 0; h < torus.halfedge_count(); h += 3)
        data.creases.push_back(
            {torus.origin(HalfedgeId(h)).value, torus.target(HalfedgeId(h)).value, k_sharpness_infinity});
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    RefineOptions options;
    options.rules.averaging_steps = 2;
    options.rules.averaging_boundary = AveragingBoundary::recede;
    const SchemeInfo& scheme = *find_scheme("averaging");
    CHECK(farthest_apart(refine(mesh, scheme, 4, options).positions,
                         refine_stencils(mesh, scheme, 4, options).mesh.positions) < 1e-11);
}

TEST_CASE("[slow] limits and normals by rows that repeat themselves are those of the rules") {
    for (const Case& c : cases()) {
        CAPTURE(c.scheme);
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        if (c.scheme == "bilinear" || c.scheme == "midpoint") continue;  // no tangents, and their own ways
        const bool triangles = scheme.family == MeshFamily::triangles;
        int repeated = 0;
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            ControlMesh mesh = make_mesh(seed, triangles, seed % 2 == 1);
            if (seed == 2) {
                // What has turned smooth before rows are learned has no effect on them.
                ControlMeshData data = mesh.data();
                for (std::uint32_t h = 0; h < mesh.halfedge_count(); h += 5)
                    data.creases.push_back(
                        {mesh.origin(HalfedgeId(h)).value, mesh.target(HalfedgeId(h)).value, 0.7f + 0.1f * (h % 2)});
                mesh = ControlMesh::build(std::move(data));
            }
            const bool limit = seed % 4 != 2;
            auto levels = std::make_unique<detail::RuleLevels>(mesh, scheme, c.rules, 0);
            detail::RepeatedRows::Demand demand;
            demand.limit = limit && !scheme.interpolating;
            demand.normals = true;
            demand.even_if_slower = true;
            const auto rows = detail::RepeatedRows::make(mesh, scheme, c.levels, c.rules, levels, demand, {});
            if (!rows) continue;
            ++repeated;
            const RefineOptions options{.rules = c.rules, .limit = limit, .normals = true};
            const RuleRefiner by_rules(mesh, scheme, c.levels, options);
            std::vector<Vec3d> points(rows->point_count()), normals(points.size()), expected(by_rules.vertex_count()),
                expected_normals(expected.size());
            rows->refine(mesh.positions(), points, normals, {});
            by_rules.refine(mesh.positions(), expected);
            by_rules.normals(mesh.positions(), expected_normals);
            const double size = bounding_box(mesh.positions()).diagonal();
            CHECK(farthest_apart(points, expected) < 1e-12 * size);
            // Points at the same place have their normals in any order.
            const auto with = [](std::vector<Vec3d> p, const std::vector<Vec3d>& n) {
                for (std::size_t i = 0; i < p.size(); ++i) p[i] += n[i];
                return p;
            };
            CHECK(farthest_apart(with(points, normals), with(expected, expected_normals)) < 1e-7);
        }
        CHECK(repeated > 1);
    }
}

TEST_CASE("rows do not repeat themselves where there are too few levels") {
    const ControlMesh smooth = make_mesh(2, true, false);
    CHECK(rows_of(smooth, {"modified-butterfly", 4}) != nullptr);
    CHECK(rows_of(smooth, {"modified-butterfly", 2}) == nullptr);
    CHECK(rows_of(smooth, {"honeycomb", 5}) == nullptr);
    ControlMeshData data = smooth.data();
    std::uint32_t inner = 0;
    while (!smooth.twin(HalfedgeId(inner)).valid()) ++inner;
    data.creases.push_back({smooth.origin(HalfedgeId(inner)).value, smooth.target(HalfedgeId(inner)).value, 3.5f});
    // Sharp for ever.
    CHECK(rows_of(ControlMesh::build(data), {"doo-sabin", 4}) != nullptr);
    CHECK(rows_of(ControlMesh::build(data), {"modified-butterfly", 4}) != nullptr);
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
