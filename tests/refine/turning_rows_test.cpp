#include "../kit/random_mesh.hpp"
#include "../kit/repeated_rows_helpers.hpp"

#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/repeated_rows.hpp"
#include "../../schemes/rules/linear.hpp"

#include <doctest/doctest.h>

#include <algorithm>
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

TEST_SUITE_END();
