#include "../kit/random_mesh.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../hier/mesh/triangulate.hpp"
#include "../../refine/adaptive/closure.hpp"

#include <doctest/doctest.h>

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

}  // namespace

TEST_SUITE_BEGIN("refine");

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

TEST_SUITE_END();
