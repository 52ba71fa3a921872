#include "../../eval/distance/limit_closest.hpp"

#include "../kit/quad_test_mesh.hpp"
#include "../kit/triangle_test_mesh.hpp"

#include "../../eval/tessellate/surface_family.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <vector>

using namespace tetrakis;

namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();

struct Sample {
    SurfaceParameter at;
    SurfacePoint point;
};

/// Points of the surface on a lattice of each root that is part of it.
template <class Patches>
std::vector<Sample> samples(const Patches& patches, bool triangles, int n) {
    const ControlMesh& mesh = patches.mesh();
    std::vector<Sample> result;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        const FaceId face = mesh.face(HalfedgeId(h));
        if (mesh.is_hole(face) || (triangles && mesh.face_halfedge(face).value != h)) continue;
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= (triangles ? n - j : n); ++i) {
                const double x = double(i) / n, y = double(j) / n;
                result.push_back({{HalfedgeId(h), x, y}, patches.evaluate(HalfedgeId(h), x, y)});
            }
    }
    return result;
}

double brute(const std::vector<Sample>& all, const Vec3d& q) {
    double best = k_infinity;
    for (const Sample& s : all) best = std::min(best, glm::length(q - s.point.position));
    return best;
}

template <class Family>
void check_mesh(const ControlMesh& mesh, bool triangles, std::uint64_t seed) {
    const typename Family::Patches patches(mesh);
    const typename Family::Closest closest(patches);
    const std::vector<Sample> coarse = samples(patches, triangles, 8);
    if (coarse.empty()) return;
    const double size = bounding_box(mesh.positions()).diagonal();
    const std::vector<Sample> fine = samples(patches, triangles, 32);
    double fine_step = 0;
    for (const Sample& s : fine)
        if (s.point.has_second)
            fine_step = std::max({fine_step, glm::length(s.point.du) / 32, glm::length(s.point.dv) / 32});
    test::Random random(seed);
    for (int i = 0; i < 30; ++i) {
        const Sample& s = coarse[random.below(static_cast<std::uint32_t>(coarse.size()))];
        // A surface point is at distance zero of itself, whatever the search starts with.
        CHECK(closest.local(s.point.position, s.at) < 1e-12 * size);
        CHECK(closest.global(s.point.position, k_infinity) < 1e-7 * size);
        const Vec3d q =
            s.point.position + 0.05 * size * Vec3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const double sampled = brute(coarse, q), start = glm::length(q - s.point.position);
        const double local = closest.local(q, s.at), global = closest.global(q, k_infinity);
        CHECK(local <= start);
        CHECK(global <= sampled + 1e-12 * size);
        // The finer the lattice, the closer to the truth, from above.
        CHECK(global >= brute(fine, q) - fine_step);
        CHECK(closest.global(q, 0.5 * global) == 0.5 * global);
        CHECK(closest.global(q, local) <= local);
    }
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("closest points of Catmull-Clark: never beyond the samples, from any start") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        check_mesh<QuadFamily>(test::random_quad_mesh(seed, CreaseMethod::uniform), false, seed);
    }
}

TEST_CASE("closest points of Loop: never beyond the samples, from any start") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        check_mesh<LoopFamily>(test::random_triangle_mesh(seed), true, seed);
    }
}

TEST_CASE("a local search finds the foot of a short normal, from a neighbouring cell too") {
    int found = 0, tried = 0;
    const auto run = [&]<class Family>(const ControlMesh& mesh, bool triangles, Family) {
        const typename Family::Patches patches(mesh);
        const typename Family::Closest closest(patches);
        const double size = bounding_box(mesh.positions()).diagonal();
        test::Random random(1);
        const std::vector<Sample> all = samples(patches, triangles, 10);
        for (const Sample& s : all) {
            if (!random.chance(0.05)) continue;
            const double h = 1e-3 * size;
            const Vec3d q = s.point.position + h * s.point.normal;
            // A start a tenth of a root away, kept inside the root.
            SurfaceParameter start = s.at;
            start.x = std::clamp(start.x + random.uniform(-0.1, 0.1), 0.0, 1.0);
            start.y = std::clamp(start.y + random.uniform(-0.1, 0.1), 0.0, triangles ? 1 - start.x : 1.0);
            ++tried;
            found += closest.local(q, start) <= h * (1 + 1e-6);
        }
    };
    test::RandomMeshOptions torus;
    torus.topology = test::Topology::torus;
    torus.columns = torus.rows = 6;
    torus.removed_faces = 0;
    torus.hole = torus.crease = torus.corner = torus.split = torus.merge = torus.edge_vertices = 0;
    torus.bumps = 0.1;
    run(test::random_mesh(1, torus), false, QuadFamily{});
    torus.triangles_only = true;
    run(test::random_mesh(1, torus), true, LoopFamily{});
    CHECK(tried > 100);
    CHECK(found == tried);
}

TEST_SUITE_END();
