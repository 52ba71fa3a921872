#include "../../eval/tessellate/surface_map.hpp"
#include "../kit/patch_meshes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

using namespace tetrakis;

namespace {

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

template <class Family>
detail::SurfaceMap<Family> map_of(const typename Family::Patches& patches) {
    detail::SurfaceMap<Family> map;
    map.patches = &patches;
    return map;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE_TEMPLATE("near points: never beyond the start", Family, QuadFamily, LoopFamily) {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<Family>(2 * seed);
        const typename Family::Patches patches(mesh);
        const detail::SurfaceMap<Family> map = map_of<Family>(patches);
        const double size = bounding_box(mesh.positions()).diagonal();
        test::Random random(seed);
        for (const Sample& s : samples<Family>(patches, 8)) {
            if (!random.chance(0.02)) continue;
            // A surface point is at distance zero of itself.
            CHECK(map.nearby_distance(s.point.position, s.at) < 1e-12 * size);
            const Vec3d q = s.point.position +
                            0.05 * size * Vec3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
            CHECK(map.nearby_distance(q, s.at) <= glm::length(q - s.point.position));
        }
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
    const detail::SurfaceMap<Family> map = map_of<Family>(patches);
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
        found += map.nearby_distance(s.point.position + h * s.point.normal, start) <= h * (1 + 1e-6);
    }
    CHECK(tried > 50);
    CHECK(found == tried);
}

TEST_CASE_TEMPLATE("near points beyond a boundary lie at the foot on its curve, not straight along the parameters",
                   Family, QuadFamily, LoopFamily) {
    // A flat sheet of sheared faces, whose first row starts at y = 0.
    ControlMeshData data = test::grid(4, std::is_same_v<Family, LoopFamily>);
    for (Vec3d& p : data.positions) p.x += 0.8 * p.y;
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    const typename Family::Patches patches(mesh);
    const detail::SurfaceMap<Family> map = map_of<Family>(patches);
    int tried = 0;
    for (const Sample& s : samples<Family>(patches, 4)) {
        const Vec3d& p = s.point.position;
        if (p.x < 1.5 || p.x > 2.5 || p.y > 0.9) continue;
        ++tried;
        CHECK(map.nearby_distance(p + Vec3d(0, -p.y - 0.4, 0.3), s.at) == doctest::Approx(0.5).epsilon(1e-6));
    }
    CHECK(tried > 10);
}

TEST_SUITE_END();
