#include "../kit/random_mesh.hpp"
#include "../kit/uniform_sites.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/closure.hpp"
#include "../../refine/uniform/uniform.hpp"

#include <doctest/doctest.h>

#include <cstring>

using namespace tetrakis;

namespace {

constexpr SchemeKind k_schemes[] = {SchemeKind::catmull_clark, SchemeKind::loop};

ControlMesh make_mesh(SchemeKind scheme, std::uint64_t seed, CreaseMethod method) {
    test::RandomMeshOptions options = test::random_options(seed);
    options.crease = seed % 3 == 0 ? 0.4 : 0.15;
    ControlMeshData data = test::random_mesh_data(seed, options);
    data.crease_method = method;
    ControlMesh mesh = ControlMesh::build(std::move(data));
    return scheme == SchemeKind::loop ? triangulate(mesh) : mesh;
}

/// Sine of the angle between the tangent plane and the chord from the vertex to a site; 0 where the chord is mostly
/// rounding.
double elevation(const Closure& closure, const LimitPoint& vertex, const Site& site) {
    const Vec3d chord = closure.limit(site).position - vertex.position;
    const double length = glm::length(chord);
    return length < 1e-10 ? 0 : std::abs(glm::dot(chord, vertex.normal)) / length;
}

bool same_bits(const Vec3d& a, const Vec3d& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

TEST_SUITE_BEGIN("refine");

TEST_CASE("[inv1] closure gives every site the positions of uniform refinement, at any level and in the limit") {
    for (const SchemeKind scheme : k_schemes)
        for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin})
            for (const std::uint64_t seed : test::seeds(8)) {
                CAPTURE(seed);
                INFO(name(scheme), method == CreaseMethod::chaikin ? ", Chaikin" : "");
                const ControlMesh mesh = make_mesh(scheme, seed, method);
                const double tolerance = 1e-12 * bounding_box(mesh.positions()).diagonal();
                const Closure closure(mesh, scheme);
                for (int level = 1; level <= 4; ++level) {
                    CAPTURE(level);
                    const std::vector<Site> sites = test::uniform_sites(mesh, scheme, level);
                    const PolygonMesh control = refine_uniform(mesh, scheme, level);
                    REQUIRE(sites.size() == control.face_vertices.size());
                    if (sites.empty()) continue;
                    std::vector<Vec3d> points(sites.size());
                    closure.control_positions(sites, sites[0].level, points);
                    double worst = 0, worst_limit = 0, worst_normal = 0;
                    for (std::size_t i = 0; i < sites.size(); ++i)
                        worst = std::max(worst, glm::length(points[i] - control.positions[control.face_vertices[i]]));
                    CHECK(worst < tolerance);
                    if (level > 3) continue;
                    const PolygonMesh limit = refine_uniform(mesh, scheme, level, {.limit = true, .normals = true});
                    std::vector<LimitPoint> limits(sites.size());
                    closure.limits(sites, limits);
                    for (std::size_t i = 0; i < sites.size(); ++i) {
                        const std::uint32_t v = limit.face_vertices[i];
                        worst_limit = std::max(worst_limit, glm::length(limits[i].position - limit.positions[v]));
                        if (limits[i].has_tangent_plane)
                            worst_normal = std::max(worst_normal, glm::length(limits[i].normal - limit.normals[v]));
                    }
                    CHECK(worst_limit < tolerance);
                    // Random n-gons and bumps have places where the tangents are nearly parallel.
                    CHECK(worst_normal < 1e-8);
                }
            }
}

TEST_CASE("[inv10] a site's bits depend on no address, batch or number of threads") {
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(3)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed, CreaseMethod::chaikin);
            const Closure closure(mesh, scheme);
            const PolygonMesh numbering = refine_uniform(mesh, scheme, 4);
            const std::vector<Site> sites = test::uniform_sites(mesh, scheme, 4);
            if (sites.empty()) continue;
            std::vector<Vec3d> together(sites.size()), threads(sites.size());
            RunContext one, three;
            one.threads = 1;
            three.threads = 3;
            with_threads(one, [&] { closure.positions(sites, together); });
            with_threads(three, [&] { closure.positions(sites, threads); });
            std::vector<std::size_t> first(numbering.positions.size(), sites.size());
            bool same = true;
            for (std::size_t i = 0; i < sites.size(); ++i) {
                std::size_t& of_vertex = first[numbering.face_vertices[i]];
                if (of_vertex == sites.size()) of_vertex = i;
                same &= same_bits(together[i], together[of_vertex]) && same_bits(together[i], threads[i]);
            }
            CHECK(same);
            for (std::size_t i = 0; i < sites.size(); i += 97)
                CHECK(same_bits(closure.limit(sites[i]).position, together[i]));
        }
}

TEST_CASE("control positions of deep levels tend to the limit, also beside tags of every kind") {
    // What is left of a level's distance shrinks by the subdominant eigenvalue, at worst slowly where many faces meet.
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(4)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed, CreaseMethod::uniform);
            const double diagonal = bounding_box(mesh.positions()).diagonal();
            const Closure closure(mesh, scheme);
            const std::vector<Site> sites = test::uniform_sites(mesh, scheme, 2);
            std::vector<Vec3d> limits(sites.size()), points(sites.size());
            closure.positions(sites, limits);
            closure.control_positions(sites, k_max_level, points);
            double worst = 0;
            for (std::size_t i = 0; i < sites.size(); ++i) worst = std::max(worst, glm::length(limits[i] - points[i]));
            CHECK(worst < 1e-9 * diagonal);
        }
}

TEST_CASE("limit tangents and normals are those of the surface nearby, where it has a tangent plane") {
    // Chords from a vertex to limit points ever nearer to it tend to the tangent plane.
    for (const SchemeKind scheme : k_schemes)
        for (const std::uint64_t seed : test::seeds(6)) {
            CAPTURE(seed);
            const ControlMesh mesh = make_mesh(scheme, seed, CreaseMethod::uniform);
            const Closure closure(mesh, scheme);
            int checked = 0;
            for (std::uint32_t i = 0; i < mesh.halfedge_count(); ++i) {
                const bool corner =
                    scheme == SchemeKind::catmull_clark || mesh.face_halfedge(mesh.face(HalfedgeId(i))).value == i;
                if (!corner) continue;
                const LimitPoint vertex = closure.limit({HalfedgeId(i), {0, 0}, 0});
                if (!vertex.has_tangent_plane) continue;
                ++checked;
                double far = 0, near = 0;
                for (const LatticePoint at : {LatticePoint{1, 0}, LatticePoint{0, 1}, LatticePoint{1, 1}}) {
                    far = std::max(far, elevation(closure, vertex, {HalfedgeId(i), at, 12}));
                    near = std::max(near, elevation(closure, vertex, {HalfedgeId(i), at, 28}));
                }
                // The slowest ratio of eigenvalues is that of a boundary with five triangles: 0.904^16 = 0.2.
                CHECK(near < 0.3 * far + 1e-4);
            }
            CHECK(checked > 0);
        }
}

TEST_CASE("Loop refuses other faces than triangles") {
    const ControlMesh mesh = make_mesh(SchemeKind::catmull_clark, 1, CreaseMethod::uniform);
    CHECK_THROWS_AS(Closure(mesh, SchemeKind::loop), Error);
    CHECK_THROWS_AS(refine_uniform(mesh, SchemeKind::loop, 1), Error);
}

TEST_SUITE_END();
