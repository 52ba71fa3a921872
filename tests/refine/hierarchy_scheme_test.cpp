#include "../../refine/adaptive/hierarchy.hpp"

#include "../kit/hierarchy_helpers.hpp"
#include "../kit/surface_topology.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../refine/rules/rule_refiner.hpp"
#include "../../refine/uniform/refine.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>

using namespace tetrakis;
using test::Random;

namespace {

/// Schemes whose points come from their rules on part of each level, and choices of Catmull-Clark and Loop.
struct Choice {
    std::string_view scheme;
    RuleOptions rules{};
};
std::vector<Choice> choices() {
    RuleOptions four, cosine;
    four.averaging_steps = 4;
    cosine.edge_beside_crease = EdgeBesideCrease::cosine;
    return {{"kobbelt"},         {"4-8"},
            {"averaging", four}, {"tuned-loop"},
            {"butterfly"},       {"modified-butterfly"},
            {"loop", cosine},    {"catmull-clark", cosine}};
}

ControlMesh mesh_for(const Choice& choice, std::uint64_t seed) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.columns = options.rows = 3;
    options.triangles_only = find_scheme(choice.scheme)->family == MeshFamily::triangles;
    return test::random_mesh(seed, options);
}

bool less(const Vec3d& a, const Vec3d& b) { return std::array{a.x, a.y, a.z} < std::array{b.x, b.y, b.z}; }

// All control points of a uniform level, by the whole mesh and the scheme's rules, holes included.
std::vector<Vec3d> uniform_points(const ControlMesh& mesh, const Choice& choice, int level) {
    RefineOptions options;
    options.rules = choice.rules;
    const RuleRefiner refiner(mesh, *find_scheme(choice.scheme), level, options);
    std::vector<Vec3d> points(refiner.vertex_count());
    refiner.refine(mesh.positions(), points);
    std::sort(points.begin(), points.end(), less);
    return points;
}

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] schemes by rules: vertices of an adaptive mesh are points of the uniform levels") {
    for (const Choice& choice : choices())
        for (const std::uint64_t seed : test::seeds(2)) {
            CAPTURE(choice.scheme);
            CAPTURE(seed);
            const ControlMesh mesh = mesh_for(choice, seed);
            HierarchyOptions options;
            options.rules = choice.rules;
            Hierarchy h = make_hierarchy(mesh, choice.scheme, options);
            if (h.leaf_count() == 0) continue;
            const bool triangles = h.family() == "triangles";
            Random random(seed);
            h.refine(test::random_subset(test::leaves_of(h), 0.4, random));
            h.refine(test::random_subset(test::leaves_of(h), 0.2, random));
            const int levels = triangles ? 2 : 3;
            const double tolerance = 1e-12 * bounding_box(mesh.positions()).diagonal();
            const HierarchyMesh finest = h.to_mesh({.positions = MeshPositions::finest});
            std::vector<std::vector<Vec3d>> uniform;
            for (int level = 0; level <= levels; ++level) uniform.push_back(uniform_points(mesh, choice, level));
            // Of points in order the one that is nearest along x, or one as near: all of those are looked at.
            const auto found = [&](const std::vector<Vec3d>& points, const Vec3d& p) {
                auto at = std::lower_bound(points.begin(), points.end(), p - Vec3d(tolerance), less);
                for (; at != points.end() && at->x <= p.x + tolerance; ++at)
                    if (glm::length(*at - p) <= tolerance) return true;
                return false;
            };
            for (int level = 1; level <= levels; ++level) {
                CAPTURE(level);
                const HierarchyMesh out = h.to_mesh({.positions = MeshPositions::level, .level = level});
                for (std::size_t v = 0; v < out.sites.size(); ++v) {
                    const int first = h.first_level(out.sites[v]);
                    if (first > level) continue;
                    REQUIRE(found(uniform[static_cast<std::size_t>(level)], out.mesh.positions[v]));
                }
            }
            for (const Vec3d& p : finest.mesh.positions) {
                bool any = false;
                for (const auto& level : uniform) any |= found(level, p);
                REQUIRE(any);
            }
            const auto topology = test::topology(test::faces_of(finest.mesh));
            CHECK(topology.fault.empty());
            CHECK(topology.euler == test::surface_topology(mesh).euler);
        }
}

TEST_CASE("[inv1] schemes by rules: refined everywhere, the points of a level are those of uniform refinement, all") {
    for (const Choice& choice : choices()) {
        CAPTURE(choice.scheme);
        test::RandomMeshOptions mesh_options;
        mesh_options.columns = mesh_options.rows = 3;
        mesh_options.hole = 0;
        mesh_options.triangles_only = find_scheme(choice.scheme)->family == MeshFamily::triangles;
        const ControlMesh mesh = test::random_mesh(3, mesh_options);
        HierarchyOptions options;
        options.rules = choice.rules;
        Hierarchy h = make_hierarchy(mesh, choice.scheme, options);
        const int levels = 2;
        const int depth = h.family() == "triangles" ? levels : 2 * (levels - 1) + 1;
        h.refine_where(each_leaf([](const LeafView&) { return true; }), depth);
        auto points = h.to_mesh({.positions = MeshPositions::level, .level = levels}).mesh.positions;
        std::sort(points.begin(), points.end(), less);
        const std::vector<Vec3d> expected = uniform_points(mesh, choice, levels);
        REQUIRE(points.size() == expected.size());
        // The paths of Catmull-Clark and Loop sum in other orders.
        double worst = 0;
        for (std::size_t i = 0; i < points.size(); ++i) worst = std::max(worst, glm::length(points[i] - expected[i]));
        CHECK(worst <= 1e-12 * bounding_box(mesh.positions()).diagonal());
    }
}

TEST_CASE("[inv1] schemes by rules: frames on a level have the normals of the uniform net") {
    for (const Choice& choice : choices())
        for (const std::uint64_t seed : test::seeds(2)) {
            CAPTURE(choice.scheme);
            CAPTURE(seed);
            test::RandomMeshOptions mesh_options = test::random_options(seed);
            mesh_options.columns = mesh_options.rows = 3;
            mesh_options.hole = 0;  // faces around a vertex for the frame, but none of the uniform net
            mesh_options.boundary_rule = BoundaryRule::edge_and_corner;
            mesh_options.triangles_only = find_scheme(choice.scheme)->family == MeshFamily::triangles;
            const ControlMesh mesh = test::random_mesh(seed, mesh_options);
            HierarchyOptions options;
            options.rules = choice.rules;
            Hierarchy h = make_hierarchy(mesh, choice.scheme, options);
            Random random(seed);
            h.refine(test::random_subset(test::leaves_of(h), 0.5, random));
            RefineOptions refine_options;
            refine_options.rules = choice.rules;
            const double size = bounding_box(mesh.positions()).diagonal();
            int compared = 0;
            for (int level = 1; level <= 2; ++level) {
                CAPTURE(level);
                const PolygonMesh net = refine(mesh, choice.scheme, level, refine_options);
                std::vector<Vec3d> area(net.positions.size(), Vec3d(0));
                for (const auto& face : test::faces_of(net)) {
                    Vec3d sum(0);
                    for (std::size_t i = 1; i + 1 < face.size(); ++i)
                        sum += glm::cross(net.positions[face[i]] - net.positions[face[0]],
                                          net.positions[face[i + 1]] - net.positions[face[0]]);
                    for (std::uint32_t v : face) area[v] += sum;
                }
                const HierarchyMesh out =
                    h.to_mesh({.positions = MeshPositions::level, .level = level, .normals = true});
                for (std::size_t v = 0; v < out.sites.size(); ++v) {
                    if (h.first_level(out.sites[v]) > level) continue;
                    const LimitPoint frame = h.frame(out.sites[v], level);
                    REQUIRE(frame.position == h.position(out.sites[v], level));
                    REQUIRE(frame.position == out.mesh.positions[v]);
                    REQUIRE(frame.normal == out.mesh.normals[v]);
                    std::size_t nearest = 0;
                    for (std::size_t w = 1; w < net.positions.size(); ++w)
                        if (glm::length(net.positions[w] - frame.position) <
                            glm::length(net.positions[nearest] - frame.position))
                            nearest = w;
                    REQUIRE(glm::length(net.positions[nearest] - frame.position) <= 1e-12 * size);
                    const double length = glm::length(area[nearest]);
                    // Where the faces around cancel out, rounding chooses the normal.
                    if (!(length > 1e-6 * size * size)) continue;
                    ++compared;
                    REQUIRE(glm::length(frame.normal - area[nearest] / length) < 1e-6);
                    const auto [t1, t2] = h.tangents(out.sites[v], level);
                    CHECK(std::abs(glm::dot(t1, frame.normal)) <= 1e-9 * glm::length(t1));
                    CHECK(glm::dot(glm::cross(t1, t2), frame.normal) > 0);
                }
            }
            CHECK(compared > 10);
            // At its finest, every vertex has the frame of its own level.
            const HierarchyMesh finest = h.to_mesh({.positions = MeshPositions::finest, .normals = true});
            for (std::size_t v = 0; v < finest.sites.size(); ++v)
                REQUIRE(glm::length(finest.mesh.normals[v]) == doctest::Approx(1));
        }
}

TEST_CASE("[inv1] schemes by rules: limits are those of uniform refinement far down, and interpolating ones stay put") {
    for (const Choice& choice : choices()) {
        CAPTURE(choice.scheme);
        test::RandomMeshOptions mesh_options;
        mesh_options.topology = test::Topology::torus;
        mesh_options.columns = mesh_options.rows = 3;
        mesh_options.removed_faces = 0;
        mesh_options.hole = mesh_options.crease = mesh_options.corner = 0;
        mesh_options.triangles_only = find_scheme(choice.scheme)->family == MeshFamily::triangles;
        const ControlMesh mesh = test::random_mesh(2, mesh_options);
        HierarchyOptions options;
        options.rules = choice.rules;
        const Hierarchy h = make_hierarchy(mesh, choice.scheme, options);
        const double size = bounding_box(mesh.positions()).diagonal();
        for (std::size_t i = 0; i < h.leaf_count(); i += 17) {
            const LeafView leaf = h.view(h.leaves()[i]);
            const Site site = leaf.corner[0];
            const Vec3d limit = h.limit(site).position;
            // Ten levels shrink what is left by the subdominant eigenvalue, 0.7 at most here, to the tenth power.
            const double far = glm::length(h.position(site, 2) - limit),
                         near = glm::length(h.position(site, 12) - limit);
            CHECK(near <= 0.05 * far + 1e-12 * size);
            if (find_scheme(choice.scheme)->interpolating)
                CHECK(glm::length(h.position(site, 0) - limit) < 1e-12 * size);
        }
    }
}

TEST_CASE("limits where a crease ends at an inner vertex of valence 2 are those of levels far down") {
    const ControlMesh mesh =
        ControlMesh::build(parse_obj("v 0.1 0 1\nv 2 0 0.3\nv 0 2 -0.3\nv -2 0 0.3\nv 0 -2 -0.3\nv 0 0.2 -1\n"
                                     "f 1 2 3 4\nf 6 5 4 3\nf 1 4 5 2\nf 6 3 2 5\nt crease 2/1/0 0 1 10\n",
                                     "test.obj"));
    for (const std::string_view scheme : {"4-8", "kobbelt", "catmull-clark"}) {
        CAPTURE(scheme);
        const Hierarchy h = make_hierarchy(mesh, scheme);
        const Site site = canonical(mesh, {mesh.vertex_halfedge(VertexId(0)), {0, 0}, 0});
        // What is left shrinks by 0.5 at most (kobbelt; 4-8: 0.317) from level to level.
        const Vec3d far = h.position(site, 24), limit = h.limit(site).position;
        CHECK(glm::length(far - limit) < 1e-6);
        if (scheme == "4-8") CHECK(glm::length(far - limit) < 1e-11);
        const PolygonMesh level = refine(mesh, scheme, 2, {.limit = true, .normals = true});
        CHECK(level.normals.size() == level.positions.size());
        double nearest = 1;
        for (const Vec3d& p : level.positions) nearest = std::min(nearest, glm::length(p - limit));
        CHECK(nearest < 1e-12);
    }
}

TEST_CASE("[bad-input] a scheme whose vertices are no sites is refused by name") {
    const ControlMesh mesh = test::hierarchy_mesh("loop", 1);
    try {
        make_hierarchy(mesh, "honeycomb");
        FAIL("no error");
    } catch (const Error& e) {
        CHECK(e.code() == ErrorCode::unsupported);
        CHECK(std::string_view(e.what()).find("honeycomb") != std::string_view::npos);
    }
}

TEST_SUITE_END();
