#include "../../schemes/core/corner_angles.hpp"

#include "../kit/corner_angle_mesh.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/random_mesh.hpp"

#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/attributes/uv_mesh.hpp"
#include "../../refine/factored/factored_mesh.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string_view>

using namespace tetrakis;
using test::contains;
using test::error_of;
using test::radians;

namespace {

constexpr std::string_view k_angle_schemes[] = {"loop", "tuned-loop", "catmull-clark"};

bool takes_triangles(std::string_view scheme) { return find_scheme(scheme)->family == MeshFamily::triangles; }

ControlMesh tagged_everywhere(const ControlMesh& mesh, double angle) {
    return test::with_angles(mesh, [&](HalfedgeId) { return angle; });
}

using test::same_bytes;

bool same(const PolygonMesh& a, const PolygonMesh& b) {
    return same_bytes(a.positions, b.positions) && same_bytes(a.normals, b.normals) && same_bytes(a.uvs, b.uvs) &&
           same_bytes(a.face_vertices, b.face_vertices) && same_bytes(a.face_uvs, b.face_uvs);
}

struct Level {
    RuleRefiner refiner;
    std::vector<Vec3d> points;

    Level(const ControlMesh& mesh, std::string_view scheme, int levels, const RefineOptions& options = {})
        : refiner(mesh, *find_scheme(scheme), levels, options), points(refiner.vertex_count()) {
        refiner.refine(mesh.positions(), points);
    }
    const RuleMesh& mesh() const { return refiner.last(); }
    /// Some half-edge that leaves a control vertex in a descendant of a control face.
    int leaving(std::uint32_t vertex, std::uint32_t face) const {
        for (int h = 0; h < mesh().halfedge_count(); ++h)
            if (mesh().origin(h) == static_cast<int>(vertex) &&
                refiner.control_face(static_cast<std::uint32_t>(mesh().face(h))) == face)
                return h;
        FAIL("no such corner");
        return 0;
    }
};

/// A face of the control mesh at the vertex, of those whose half-edge leaves it in about this direction.
std::uint32_t face_towards(const ControlMesh& mesh, std::uint32_t vertex, double x, double y) {
    std::uint32_t best = 0;
    double most = -1e9;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        if (mesh.origin(HalfedgeId(h)).value != vertex) continue;
        const FaceId f = mesh.face(HalfedgeId(h));
        Vec3d sum(0);
        for (std::uint32_t c = 0; c < mesh.face_size(f); ++c)
            sum += mesh.position(mesh.origin(HalfedgeId(mesh.face_halfedge(f).value + c)));
        const Vec3d out = sum / double(mesh.face_size(f)) - mesh.positions()[vertex];
        if (x * out.x + y * out.y <= most) continue;
        most = x * out.x + y * out.y;
        best = f.value;
    }
    return best;
}

/// The tags of one sector.
ControlMesh tagged_at(const ControlMesh& mesh, std::initializer_list<ControlMeshData::AngleTag> tags) {
    ControlMeshData data = mesh.data();
    data.corner_angles.assign(tags);
    return ControlMesh::build(std::move(data));
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("the ring of a corner becomes the affine image of a planar fan of its sector's own angle") {
    constexpr int k_levels = 4;
    for (const std::string_view scheme : k_angle_schemes) {
        const ControlMesh mesh = test::sheet(takes_triangles(scheme));
        struct Sector {
            std::uint32_t vertex;
            double x, y, degrees;
        };
        // The inner side of the bend has one quad alone: whatever it has, its edges are creases.
        for (const Sector& s : {Sector{test::k_straight, 0.1, 1, 110}, Sector{test::k_straight, 0.1, -1, 250},
                                Sector{test::k_bent, 1, 1, 270}}) {
            CAPTURE(scheme);
            CAPTURE(s.degrees);
            const std::uint32_t face = face_towards(mesh, s.vertex, s.x, s.y);
            const double alpha = radians(s.degrees);
            // Sines of the farthest direction from where the plane has it, level by level.
            const auto off = [&](int levels, const ControlMesh& control) {
                const Level level(control, scheme, levels);
                const RuleMesh::Ring sector = level.mesh().sector(level.leaving(s.vertex, face));
                const Vec3d c = level.points[s.vertex];
                const auto at = [&](int i) {
                    return level.points[static_cast<std::size_t>(sector.neighbour[static_cast<std::size_t>(i)])] - c;
                };
                const int K = sector.faces();
                double most = 0;
                for (int i = 1; i < K; ++i) {
                    const double theta = i * alpha / K;
                    const Vec3d expected =
                        (std::sin(alpha - theta) * at(0) + std::sin(theta) * at(K)) / std::sin(alpha);
                    most = std::max(most, glm::length(at(i) - expected) / glm::length(expected));
                }
                return most;
            };
            const ControlMesh tagged = tagged_at(mesh, {{s.vertex, face, alpha}});
            const double last = off(k_levels, tagged), before = off(k_levels - 1, tagged);
            // Concave: what is off the plane loses half of its share in each step (eigenvalue 1/4 to 1/2).
            CHECK(last < (alpha > std::numbers::pi ? 0.55 : 0.9) * before);
            CHECK(last < (alpha > std::numbers::pi ? 0.16 : 0.7) * off(1, tagged));
            CHECK(last < 0.6 * off(k_levels, mesh));
        }
    }
}

TEST_CASE("measured angles are those of the faces in the control mesh") {
    // A cube of triangles with all edges sharp: six of its 24 right angles at corners are cut in two.
    ControlMesh cube = triangulate(ControlMesh::build(
        test::mesh_data({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                        {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}})));
    ControlMeshData data = cube.data();
    for (std::uint32_t e = 0; e < cube.edge_count(); ++e) {
        const HalfedgeId h = cube.edge_halfedge(EdgeId(e));
        const std::uint32_t a = cube.origin(h).value, b = cube.target(h).value;
        if (glm::length(cube.positions()[a] - cube.positions()[b]) < 1.1)
            data.creases.push_back({a, b, k_infinite_sharpness});
    }
    cube = ControlMesh::build(std::move(data));
    RuleOptions measured;
    measured.measure_corner_angles = true;
    const ControlMesh tagged = tagged_everywhere(cube, radians(90));
    for (const std::string_view scheme : k_angle_schemes) {
        CAPTURE(scheme);
        const RefineOptions options{.rules = measured, .limit = true, .normals = true};
        CHECK(same(refine(cube, scheme, 2, options), refine(tagged, scheme, 2, {.limit = true, .normals = true})));
        CHECK(!same_bytes(refine(cube, scheme, 2, options).positions,
                          refine(cube, scheme, 2, {.limit = true}).positions));
        // Tags come first.
        const ControlMesh other = tagged_everywhere(cube, radians(70));
        CHECK(same(refine(other, scheme, 2, options), refine(other, scheme, 2, {.limit = true, .normals = true})));
    }
    // A face may be concave there.
    auto bracket =
        test::mesh_data({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, {{0, 1, 2, 3, 4, 5}});
    const RuleMesh rules = rule_mesh(ControlMesh::build(bracket), measured);
    for (int h = 0; h < 6; ++h) CHECK(rules.corner_angle(h) == doctest::Approx(radians(h == 3 ? 270 : 90)));
    CHECK(usable_corner_angle(radians(90)) == radians(90));
    CHECK(usable_corner_angle(radians(171)) == radians(170));
    CHECK(usable_corner_angle(radians(189)) == radians(170));
    CHECK(usable_corner_angle(radians(191)) == radians(191));
    CHECK(usable_corner_angle(radians(420)) == radians(350));
}

TEST_CASE("where a crease between two sectors goes smooth, what is left has the sum of their angles") {
    const ControlMesh mesh = test::sheet(false);
    const std::uint32_t v = test::k_straight, right = face_towards(mesh, v, 1, 0.5),
                        left = face_towards(mesh, v, -1, 0.5);
    const auto with_crease = [&](float sharpness, std::initializer_list<ControlMeshData::AngleTag> tags) {
        ControlMeshData data = mesh.data();
        data.creases.push_back({v, v + 8, sharpness});
        data.corner_angles.assign(tags);
        return rule_mesh(ControlMesh::build(std::move(data)));
    };
    const auto angles = [&](const RuleMesh& rules, int levels) {
        RuleMesh at = rules;
        for (int i = 0; i < levels; ++i) at = find_scheme("catmull-clark")->step(at, {}).mesh;
        std::vector<double> result;
        for (const int h : at.ring(static_cast<int>(v)).halfedge) result.push_back(at.corner_angle(h));
        std::sort(result.begin(), result.end());
        return result;
    };
    const double a = radians(40), b = radians(60);
    const RuleMesh both = with_crease(1.5f, {{v, right, a}, {v, left, b}});
    CHECK(angles(both, 1) == std::vector<double>{0, 0, a, b});
    CHECK(angles(both, 2) == std::vector<double>{0, 0, a + b, a + b});
    CHECK(angles(both, 3) == std::vector<double>{0, 0, a + b, a + b});
    CHECK(angles(with_crease(1, {{v, right, radians(90)}, {v, left, radians(90)}}), 1) ==
          std::vector<double>{0, 0, radians(170), radians(170)});
    CHECK(angles(with_crease(1, {{v, right, a}}), 1) == std::vector<double>{0, 0, 0, 0});
}

TEST_CASE("charts have the angles of their corners' sectors, and shares of those that a seam cuts") {
    ControlMeshData data = tagged_everywhere(test::sheet(false), radians(120)).data();
    // Left and right of x = 5 are two charts: the bend's sector of three quads has one on the left.
    const auto count = static_cast<std::uint32_t>(data.uvs.size());
    for (std::uint32_t i = 0; i < count; ++i) data.uvs.push_back(data.uvs[i] + Vec2d(3, 0));
    for (std::uint32_t h = 0; h < data.face_vertices.size(); ++h)
        if (h / 4 % 7 >= 5) data.face_uvs[h] += count;
    data.face_varying_rule = FaceVaryingRule::boundaries;
    const ControlMesh mesh = ControlMesh::build(data), chart = uv_mesh(mesh);
    const auto at = [&](std::uint32_t vertex, double x, double y) {
        const FaceId f(face_towards(mesh, vertex, x, y));
        std::uint32_t h = mesh.face_halfedge(f).value;
        while (mesh.origin(HalfedgeId(h)).value != vertex) ++h;
        return chart.corner_angle(HalfedgeId(h));
    };
    CHECK(at(test::k_straight, 1, 1) == radians(120));
    CHECK(at(test::k_bent, -1, -1) == radians(120));
    CHECK(at(test::k_bent, -1, 1) == doctest::Approx(radians(40)));
    CHECK(at(test::k_bent, 1, 1) == doctest::Approx(radians(80)));
    CHECK(at(test::k_bent, 1, -1) == at(test::k_bent, 1, 1));
    // Measured in space, not in the plane of the charts.
    RuleOptions measured;
    measured.measure_corner_angles = true;
    const ControlMesh plain = test::sheet(false), by_space = uv_mesh(plain, measured);
    const RuleMesh rules = rule_mesh(plain, measured);
    int angles = 0;
    for (std::uint32_t h = 0; h < plain.halfedge_count(); ++h) {
        CHECK(by_space.corner_angle(HalfedgeId(h)) == rules.corner_angle(static_cast<int>(h)));
        angles += rules.corner_angle(static_cast<int>(h)) != 0 ? 1 : 0;
    }
    CHECK(angles == 4 + 4 + 4 + 2);  // the two corners, the sheet's own, and where a crease meets its end
    CHECK(!detail::chart_rules(measured).measure_corner_angles);
}

TEST_CASE("[bad-input] what has no rule for corner angles refuses them, or says that they are ignored") {
    const ControlMesh mesh = tagged_everywhere(test::sheet(false), radians(100));
    const auto warned = [](const std::vector<std::string>& warnings) {
        return std::ranges::any_of(warnings, [](const auto& w) { return contains(w, "corner angles were ignored"); });
    };
    for (const std::string_view scheme : {"kobbelt", "4-8", "doo-sabin", "bilinear"}) {
        CAPTURE(scheme);
        CHECK(warned(refine(mesh, scheme, 1).warnings));
        CHECK(same_bytes(refine(mesh, scheme, 1).positions, refine(test::sheet(false), scheme, 1).positions));
    }
    CHECK(!warned(refine(mesh, "catmull-clark", 1).warnings));
    CHECK(warned(FactoredMesh(mesh, FactoredScheme::catmull_clark).mesh().warnings));
    RuleMesh::Builder faces;
    faces.face({0, 1, 2});
    faces.set_corner_angles({0, 7, 0});
    CHECK_THROWS_AS(RuleMesh(3, faces), std::invalid_argument);
    faces.set_corner_angles({1, 1});
    CHECK_THROWS_AS(RuleMesh(3, faces), std::invalid_argument);
}

TEST_SUITE_END();
