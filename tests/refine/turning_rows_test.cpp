#include "../kit/random_mesh.hpp"
#include "../kit/repeated_rows_helpers.hpp"

#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/repeated_rows.hpp"
#include "../../schemes/rules/linear.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

using namespace tetrakis;

namespace {

/// Tags that turn smooth on several levels, some of them on the last but one, on the last or after it.
ControlMesh with_turning_tags(const ControlMesh& mesh, std::uint64_t seed, int levels) {
    ControlMeshData data = mesh.data();
    data.creases.clear();
    data.corners.clear();
    test::Random random(seed);
    const float sharpness[] = {
        0.6f, 1.0f, float(levels) - 1, float(levels) - 0.4f, float(levels) + 0.5f, k_sharpness_infinity};
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        const HalfedgeId h = mesh.edge_halfedge(EdgeId(e));
        if (mesh.is_boundary(EdgeId(e)) || !random.chance(0.25)) continue;
        data.creases.push_back({mesh.origin(h).value, mesh.target(h).value, sharpness[random.below(6)]});
    }
    data.corners.push_back({random.below(mesh.vertex_count()), sharpness[3]});
    data.corners.push_back({random.below(mesh.vertex_count()), sharpness[0]});
    return ControlMesh::build(std::move(data));
}

/// Tags of dual schemes that turn smooth before the last step or after it, some sooner.
ControlMesh with_late_tags(const ControlMesh& mesh, std::uint64_t seed, int levels) {
    ControlMeshData data = mesh.data();
    data.creases.clear();
    data.corners.clear();
    test::Random random(seed);
    const float sharpness[] = {float(levels) - 1,    float(levels) - 0.4f, float(levels) - 1.5f, float(levels) + 0.5f,
                               k_sharpness_infinity, float(levels) - 3,    float(levels) - 2.3f};
    for (std::uint32_t e = 0; e < mesh.edge_count(); ++e) {
        const HalfedgeId h = mesh.edge_halfedge(EdgeId(e));
        if (mesh.is_boundary(EdgeId(e)) || !random.chance(0.2)) continue;
        data.creases.push_back(
            {mesh.origin(h).value, mesh.target(h).value, sharpness[random.below(seed % 2 == 0 ? 7 : 5)]});
    }
    for (int i = 0; i < 4; ++i) data.corners.push_back({random.below(mesh.vertex_count()), sharpness[i]});
    for (std::uint32_t v = 0, i = 0; v < mesh.vertex_count(); ++v)
        if (!mesh.is_isolated(VertexId(v)) && mesh.is_boundary(VertexId(v)) && random.chance(0.3))
            data.corners.push_back({v, sharpness[i++ % 5]});
    return ControlMesh::build(std::move(data));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[slow] rows of tags that turn smooth on the way are those of the rules, limits and normals as well") {
    for (const test::Case& c : test::cases()) {
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        if (fan_lattice(scheme, c.rules) == FanLattice::dual) continue;
        CAPTURE(c.scheme);
        const bool triangles = scheme.family == MeshFamily::triangles;
        int repeated = 0;
        for (const std::uint64_t seed : test::seeds(6)) {
            CAPTURE(seed);
            const ControlMesh mesh = with_turning_tags(test::make_mesh(seed, triangles, false), seed, c.levels);
            const bool limits = seed % 2 == 1 && !is_linear(scheme);
            auto levels = std::make_unique<detail::RuleLevels>(mesh, scheme, c.rules, 0);
            detail::RepeatedRows::Demand demand;
            demand.limit = limits && !scheme.interpolating;
            demand.normals = limits;
            demand.even_if_slower = true;
            const auto rows = detail::RepeatedRows::make(mesh, scheme, c.levels, c.rules, levels, demand, {});
            if (!rows) continue;
            ++repeated;
            const RefineOptions options{.rules = c.rules, .limit = demand.limit, .normals = limits};
            const RuleRefiner by_rules(mesh, scheme, c.levels, options);
            std::vector<Vec3d> points(rows->point_count()), normals(limits ? points.size() : 0),
                expected(by_rules.vertex_count()), expected_normals(normals.size());
            rows->refine(mesh.positions(), points, normals, {});
            by_rules.refine(mesh.positions(), expected, expected_normals);
            const double size = bounding_box(mesh.positions()).diagonal();
            CHECK(test::farthest_apart(points, expected) < 1e-12 * size);
            PolygonMesh ours;
            detail::RepeatedRows::Faces faces = rows->faces({});
            ours.positions = points;
            ours.face_offsets = std::move(faces.offsets);
            ours.face_vertices = std::move(faces.vertices);
            CHECK(test::farthest_apart(test::marks(ours, false), test::marks(test::mesh_of(by_rules, expected),
                                                                             false)) < 1e-11 * (size + size * size));
            // Points at the same place have their normals in any order.
            for (std::size_t i = 0; i < normals.size(); ++i) {
                points[i] += normals[i];
                expected[i] += expected_normals[i];
            }
            if (limits) CHECK(test::farthest_apart(points, expected) < 1e-7);
        }
        CHECK(repeated == static_cast<int>(test::seeds(6).size()));
    }
}

namespace {

/// The last levels of a dual scheme, where tags turn smooth late.
struct Refined {
    PolygonMesh mesh;
    std::vector<Vec3d> normals;
    std::vector<std::uint32_t> control;
};

/// With the points that faces use alone.
Refined by_rows(const detail::RepeatedRows& rows, const ControlMesh& mesh, bool normals) {
    Refined result;
    std::vector<Vec3d> points(rows.point_count()), all_normals(normals ? points.size() : 0);
    rows.refine(mesh.positions(), points, all_normals, {});
    detail::RepeatedRows::Faces faces = rows.faces({});
    result.mesh.face_offsets = std::move(faces.offsets);
    result.control = std::move(faces.control);
    std::vector<std::uint32_t> number(points.size(), UINT32_MAX);
    for (std::uint32_t v : faces.vertices) {
        if (number[v] == UINT32_MAX) {
            number[v] = static_cast<std::uint32_t>(result.mesh.positions.size());
            result.mesh.positions.push_back(points[v]);
            if (normals) result.normals.push_back(all_normals[v]);
        }
        result.mesh.face_vertices.push_back(number[v]);
    }
    return result;
}

}  // namespace

TEST_CASE("[slow] dual schemes' tags that turn smooth late leave what the rules leave, limits and normals as well") {
    for (const test::Case& c : test::cases()) {
        const SchemeInfo& scheme = *find_scheme(c.scheme);
        if (fan_lattice(scheme, c.rules) != FanLattice::dual) continue;
        CAPTURE(c.scheme);
        int repeated = 0;
        for (const std::uint64_t seed : test::seeds(6)) {
            CAPTURE(seed);
            const ControlMesh mesh = with_late_tags(test::make_mesh(seed % 6, false, false), seed, c.levels);
            const bool limits = seed % 3 == 1;
            auto levels = std::make_unique<detail::RuleLevels>(mesh, scheme, c.rules, 0);
            detail::RepeatedRows::Demand demand;
            demand.limit = limits;
            demand.normals = limits || seed % 3 == 2;
            demand.even_if_slower = true;
            const auto rows = detail::RepeatedRows::make(mesh, scheme, c.levels, c.rules, levels, demand, {});
            if (!rows) continue;
            ++repeated;
            for (const int threads : {1, 3}) {
                RunContext context;
                context.threads = threads;
                std::vector<Vec3d> points(rows->point_count()), again(points.size());
                rows->refine(mesh.positions(), points, {}, {});
                with_threads(context, [&] { rows->refine(mesh.positions(), again, {}, context); });
                CHECK(std::memcmp(points.data(), again.data(), points.size() * sizeof(Vec3d)) == 0);
            }
            const RefineOptions options{.rules = c.rules, .limit = demand.limit, .normals = demand.normals};
            const RuleRefiner by_rules(mesh, scheme, c.levels, options);
            Refined ours = by_rows(*rows, mesh, demand.normals);
            std::vector<Vec3d> expected(by_rules.vertex_count()),
                expected_normals(demand.normals ? expected.size() : 0);
            by_rules.refine(mesh.positions(), expected, expected_normals);
            const double size = bounding_box(mesh.positions()).diagonal();
            CHECK(test::farthest_apart(ours.mesh.positions, expected) < 1e-12 * size);
            CHECK(test::farthest_apart(test::marks(ours.mesh, false),
                                       test::marks(test::mesh_of(by_rules, expected), false)) <
                  1e-11 * (size + size * size));
            std::vector<int> cells(mesh.face_count(), 0);
            for (std::uint32_t f = 0; f < by_rules.face_count(); ++f) --cells[by_rules.control_face(f)];
            for (const std::uint32_t f : ours.control) ++cells[f];
            CHECK(std::ranges::count(cells, 0) == static_cast<std::ptrdiff_t>(cells.size()));
            for (std::size_t i = 0; i < ours.normals.size(); ++i) {
                ours.mesh.positions[i] += ours.normals[i];
                expected[i] += expected_normals[i];
            }
            if (demand.normals) CHECK(test::farthest_apart(ours.mesh.positions, expected) < 1e-7);
        }
        CHECK(repeated >= 5);
    }
}

TEST_CASE("three creases of a dual scheme's corner, one of which turns smooth three steps before the last") {
    constexpr std::uint32_t n = 4, middle = 2 * (n + 1) + 2;
    ControlMeshData data = test::skewed_grid(n);
    data.creases = {{middle, middle + 1, 2.7f},
                    {middle, middle - 1, k_sharpness_infinity},
                    {middle, middle + n + 1, 3.3f},
                    {middle + 1, middle + 2, 2.7f}};
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    const SchemeInfo& scheme = *find_scheme("doo-sabin");
    auto levels = std::make_unique<detail::RuleLevels>(mesh, scheme, RuleOptions{}, 0);
    const auto rows = detail::RepeatedRows::make(mesh, scheme, 6, {}, levels, {.even_if_slower = true}, {});
    REQUIRE(rows != nullptr);
    const RuleRefiner by_rules(mesh, scheme, 6, {});
    const Refined ours = by_rows(*rows, mesh, false);
    std::vector<Vec3d> expected(by_rules.vertex_count());
    by_rules.refine(mesh.positions(), expected);
    CHECK(test::farthest_apart(ours.mesh.positions, expected) < 1e-11);
    CHECK(ours.mesh.face_count() == by_rules.face_count());
}

TEST_SUITE_END();
