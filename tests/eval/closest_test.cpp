#include "../../eval/distance/limit_closest.hpp"
#include "../../eval/distance/nearest_in_root.hpp"
#include "../kit/patch_meshes.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
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

/// Two apices over a ring of n vertices; the faces around the first are halved by a second ring, so that some are
/// quads.
ControlMesh bipyramid(std::uint32_t n, bool quads) {
    std::vector<Vec3d> positions{{0, 0, 1}, {0, 0, -1}};
    std::vector<std::vector<std::uint32_t>> faces;
    for (std::uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * i / n;
        positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    for (std::uint32_t i = 0; quads && i < n; ++i) positions.push_back(0.5 * (positions[2 + i] + positions[0]));
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 + i, b = 2 + (i + 1) % n;
        faces.push_back({1, b, a});
        faces.push_back(quads ? std::vector{0u, a + n, b + n} : std::vector{0u, a, b});
        if (quads) faces.push_back({a, b, b + n, a + n});
    }
    return ControlMesh::build(test::mesh_data(std::move(positions), faces));
}

/// Points beside the surface within the first faces, down to the first apex; the search against that of every root.
template <class Closest, class Patches, class Frame>
void check_search(const ControlMesh& mesh, detail::RootShape shape, Frame&& frame, std::uint64_t seed) {
    const Patches patches(mesh);
    const Closest closest(patches);
    closest.prepare({});
    test::Random random(seed);
    const bool square = shape == detail::RootShape::square;
    for (int i = 0; i < 12; ++i) {
        const HalfedgeId leaving = mesh.vertex_halfedge(VertexId(0));
        const double near = std::pow(10.0, random.uniform(-3, 0));
        double x = 0.45 * near, y = 0.45 * near * random.uniform(0, 1);
        HalfedgeId root = leaving;
        if (!square) {
            root = mesh.face_halfedge(mesh.face(leaving));
            std::array<double, 3> b{};
            const std::uint32_t k = leaving.value - root.value;
            b[k] = 1 - x - y, b[(k + 1) % 3] = x, b[(k + 2) % 3] = y;
            x = b[1], y = b[2];
        }
        const SurfacePoint s = frame(patches, root, x, y);
        const Vec3d q = s.position + near * random.uniform(-0.1, 0.1) * Vec3d(0.1, 0.2, 1);
        const double start = glm::length(q - s.position);
        double expected = start;
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); h += square ? 1 : 3)
            expected = std::min(
                expected, detail::nearest_in_root(
                              shape, false, q, [&](double u, double v) { return frame(patches, HalfedgeId(h), u, v); },
                              [&](double u, double v) { return frame(patches, HalfedgeId(h), u, v).position; }));
        CHECK(std::abs(closest.global(q, start) - expected) <= 1e-14);
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

TEST_CASE("[slow] beside a vertex of many edges the closest point is that of a search of every root") {
    for (const std::uint32_t n : {24u, 70u}) {
        CAPTURE(n);
        for (const bool quads : {false, true})
            check_search<QuadClosest, QuadPatches>(
                bipyramid(n, quads), detail::RootShape::square,
                [](const QuadPatches& p, HalfedgeId root, double x, double y) { return p.frame(root, x, y); }, n);
        check_search<LoopClosest, LoopPatches>(
            bipyramid(n, false), detail::RootShape::triangle,
            [](const LoopPatches& p, HalfedgeId root, double x, double y) { return p.frame(root, x, y); }, n);
    }
}

TEST_SUITE_END();
