#include "../../eval/distance/limit_closest.hpp"

#include "../kit/patch_meshes.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <vector>

using namespace tetrakis;

namespace {

constexpr double k_anywhere = std::numeric_limits<double>::infinity();

struct Sample {
    SurfaceParameter at;
    SurfacePoint point;
};

/// Points of the surface on a lattice of each root that is part of it.
template <class Family>
std::vector<Sample> samples(const typename Family::Patches& patches, int n) {
    std::vector<Sample> result;
    for (const HalfedgeId root : test::roots_of<Family>(patches.mesh()))
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i) {
                const double x = double(i) / n, y = double(j) / n;
                if (Family::inside(x, y)) result.push_back({{root, x, y}, patches.evaluate(root, x, y)});
            }
    return result;
}

double brute(const std::vector<Sample>& all, const Vec3d& q) {
    double best = k_anywhere;
    for (const Sample& s : all) best = std::min(best, glm::length(q - s.point.position));
    return best;
}

template <class Family>
void check_mesh(const ControlMesh& mesh, std::uint64_t seed) {
    const typename Family::Patches patches(mesh);
    const typename Family::Closest closest(patches);
    const std::vector<Sample> coarse = samples<Family>(patches, 8);
    if (coarse.empty()) return;
    const double size = bounding_box(mesh.positions()).diagonal();
    const std::vector<Sample> fine = samples<Family>(patches, 32);
    double fine_step = 0;
    for (const Sample& s : fine)
        if (s.point.has_second)
            fine_step = std::max({fine_step, glm::length(s.point.du) / 32, glm::length(s.point.dv) / 32});
    test::Random random(seed);
    for (int i = 0; i < 30; ++i) {
        const Sample& s = coarse[random.below(static_cast<std::uint32_t>(coarse.size()))];
        // A surface point is at distance zero of itself, whatever the search starts with.
        CHECK(closest.local(s.point.position, s.at) < 1e-12 * size);
        CHECK(closest.global(s.point.position, k_anywhere) < 1e-7 * size);
        const Vec3d q =
            s.point.position + 0.05 * size * Vec3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const double sampled = brute(coarse, q), start = glm::length(q - s.point.position);
        const double local = closest.local(q, s.at), global = closest.global(q, k_anywhere);
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

TEST_CASE_TEMPLATE("closest points: never beyond the samples, from any start", Family, QuadFamily, LoopFamily) {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        check_mesh<Family>(test::random_patch_mesh<Family>(2 * seed), seed);
    }
}

TEST_CASE_TEMPLATE("a local search finds the foot of a short normal, from a neighbouring cell too", Family, QuadFamily,
                   LoopFamily) {
    test::RandomMeshOptions torus;
    torus.topology = test::Topology::torus;
    torus.columns = torus.rows = 6;
    torus.removed_faces = 0;
    torus.hole = torus.crease = torus.corner = torus.split = torus.merge = torus.edge_vertices = 0;
    torus.bumps = 0.1;
    torus.triangles_only = std::is_same_v<Family, LoopFamily>;
    const ControlMesh mesh = test::random_mesh(1, torus);
    const typename Family::Patches patches(mesh);
    const typename Family::Closest closest(patches);
    const double h = 1e-3 * bounding_box(mesh.positions()).diagonal();
    test::Random random(1);
    int found = 0, tried = 0;
    for (const Sample& s : samples<Family>(patches, 10)) {
        if (!random.chance(0.05)) continue;
        // A start a tenth of a root away, kept inside the root.
        SurfaceParameter start = s.at;
        start.x = std::clamp(start.x + random.uniform(-0.1, 0.1), 0.0, 1.0);
        start.y = std::clamp(start.y + random.uniform(-0.1, 0.1), 0.0, torus.triangles_only ? 1 - start.x : 1.0);
        ++tried;
        found += closest.local(s.point.position + h * s.point.normal, start) <= h * (1 + 1e-6);
    }
    CHECK(tried > 50);
    CHECK(found == tried);
}

TEST_SUITE_END();
