#include "../../eval/estimate/hierarchy_estimator.hpp"
#include "../../eval/estimate/linear_bound.hpp"
#include "../../eval/patches/limit_surface.hpp"
#include "../../eval/patches/loop_patches.hpp"
#include "../../eval/patches/quad_patches.hpp"
#include "../../eval/surface/local_frame.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/parallel.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "../../refine/adaptive/hierarchy.hpp"
#include "../../schemes/core/scheme_table.hpp"
#include "../kit/hierarchy_helpers.hpp"
#include "../kit/patch_meshes.hpp"

#include <doctest/doctest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <type_traits>
#include <vector>

// Patch trees of Catmull-Clark and Loop.

using namespace tetrakis;
using test::Random;

namespace {

double diagonal(const ControlMesh& mesh) { return bounding_box(mesh.positions()).diagonal(); }

template <class Family>
constexpr SchemeKind k_kind = std::is_same_v<Family, LoopFamily> ? SchemeKind::loop : SchemeKind::catmull_clark;

/// All lattice points of a root on one level.
template <class Family>
std::vector<Site> lattice(HalfedgeId root, std::uint8_t level) {
    const std::uint32_t n = 1u << level;
    std::vector<Site> sites;
    for (std::uint32_t y = 0; y <= n; ++y)
        for (std::uint32_t x = 0; x <= n; ++x)
            if (Family::inside(double(x) / n, double(y) / n)) sites.push_back({root, {x, y}, level});
    return sites;
}

/// A flat ring of K faces with edges of length 1 over `opening` radians; z up.
/// @param sharp  the sharp edges
detail::CornerRing flat_ring(SchemeKind scheme, int K, double opening, bool boundary,
                             std::initializer_list<int> sharp) {
    detail::CornerRing ring;
    ring.scheme = scheme;
    ring.boundary = boundary;
    const auto at = [&](double i, double r) {
        const double a = opening * i / K;
        return Vec3d(r * std::cos(a), r * std::sin(a), 0);
    };
    for (int i = 0; i < K + (boundary ? 1 : 0); ++i) {
        const bool end = boundary && (i == 0 || i == K);
        const bool is_sharp = end || std::find(sharp.begin(), sharp.end(), i) != sharp.end();
        ring.spokes.push_back({at(i, 1), at(i + 0.5, 1.4), is_sharp ? k_sharpness_infinity : 0});
    }
    return ring;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE_TEMPLATE("[inv1] patch trees give the limits of repeated rows, tags of all kinds included", Family,
                   QuadFamily, LoopFamily) {
    for (const std::uint64_t seed : test::seeds(24)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<Family>(seed);
        const typename Family::Patches patches(mesh);
        const Hierarchy rows = make_hierarchy(mesh, name(k_kind<Family>));
        test::Random random(seed);
        double off = 0, turned = 0;
        for (const HalfedgeId root : test::roots_of<Family>(mesh)) {
            std::vector<Site> sites = lattice<Family>(root, 2);
            for (int i = 0; i < 6; ++i) {
                const auto level = static_cast<std::uint8_t>(3 + random.below(2));
                const std::uint32_t n = 1u << level, x = random.below(n + 1), y = random.below(n + 1);
                if (Family::inside(double(x) / n, double(y) / n)) sites.push_back({root, {x, y}, level});
            }
            std::vector<LimitPoint> limits(sites.size());
            rows.limits(sites, limits);
            for (std::size_t i = 0; i < sites.size(); ++i) {
                const Site& s = sites[i];
                const SurfacePoint p = patches.vertex(s.root, s.at, s.level);
                off = std::max({off, glm::length(p.position - limits[i].position),
                                glm::length(patches.limit(s.root, s.at, s.level) - p.position)});
                // Surfaces folded flat have points without any direction across, which rounding decides.
                const Vec3d &a = limits[i].tangent1, &b = limits[i].tangent2;
                if (limits[i].has_tangent_plane &&
                    glm::length(glm::cross(a, b)) > 1e-6 * glm::length(a) * glm::length(b))
                    turned = std::max(turned, glm::length(p.normal - limits[i].normal));
            }
        }
        CHECK(off < 1e-12 * diagonal(mesh));
        // Random n-gons and bumps have points where the tangents are nearly parallel.
        CHECK(turned < 1e-7);
    }
}

TEST_CASE("Catmull-Clark patches: second derivatives are absent at extraordinary points alone") {
    for (const std::uint64_t seed : test::seeds(4)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<QuadFamily>(2 * seed);
        const QuadPatches patches(mesh);
        int absent = 0, present = 0;
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
            const HalfedgeId root(h);
            const VertexId v = mesh.origin(root);
            if (mesh.is_boundary(v)) continue;
            const bool second = patches.evaluate(root, 0.0, 0.0).has_second;
            if (mesh.valence(v) != 4) CHECK_FALSE(second);
            (second ? present : absent)++;
            CHECK(patches.evaluate(root, 0.013, 0.007).has_second);
        }
        CHECK(absent > 0);
    }
}

TEST_CASE_TEMPLATE("derivatives of patches are those of finite differences", Family, QuadFamily, LoopFamily) {
    int checked = 0;
    for (const std::uint64_t seed : test::seeds(16)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<Family>(seed);
        const typename Family::Patches patches(mesh);
        test::Random random(seed);
        for (const HalfedgeId root : test::roots_of<Family>(mesh)) {
            const double x = random.uniform(0.001, 0.999), y = random.uniform(0.001, 0.999);
            if (!Family::inside(x + 1e-3, y)) continue;
            const SurfacePoint p = patches.evaluate(root, x, y);
            REQUIRE(p.has_second);
            // Where patches or the strips of a crease meet, third derivatives jump: not there.
            constexpr double h = 1e-5;
            const auto at = [&](double a, double b) { return patches.evaluate(root, x + a * h, y + b * h); };
            const auto jump = [&](const SurfacePoint& q) {
                return glm::length(q.duu - p.duu) + glm::length(q.duv - p.duv) + glm::length(q.dvv - p.dvv);
            };
            const double size = glm::length(p.duu) + glm::length(p.duv) + glm::length(p.dvv) + diagonal(mesh);
            double jumps = 0;
            for (const auto& [a, b] : {std::pair{2, 0}, {-2, 0}, {0, 2}, {0, -2}})
                jumps = std::max(jumps, jump(at(a, b)));
            if (jumps > 1e-3 * size) continue;
            ++checked;
            const Vec3d du = (at(1, 0).position - at(-1, 0).position) / (2 * h);
            const Vec3d dv = (at(0, 1).position - at(0, -1).position) / (2 * h);
            CHECK(glm::length(du - p.du) < 1e-7 * size);
            CHECK(glm::length(dv - p.dv) < 1e-7 * size);
            CHECK(glm::length((at(1, 0).du - at(-1, 0).du) / (2 * h) - p.duu) < 2e-3 * size);
            CHECK(glm::length((at(0, 1).du - at(0, -1).du) / (2 * h) - p.duv) < 2e-3 * size);
            CHECK(glm::length((at(0, 1).dv - at(0, -1).dv) / (2 * h) - p.dvv) < 2e-3 * size);
        }
    }
    CHECK(checked > 100);
}

TEST_CASE("single-crease patches: the closed form is what repeated subdivision tends to") {
    using namespace tetrakis::detail;
    test::Random random(3);
    for (const float sharpness : {0.3f, 0.75f, 1.0f, 1.5f, 2.0f, 3.25f, 4.0f, 7.9f})
        for (std::int8_t side = 0; side < 4; ++side) {
            CAPTURE(sharpness);
            CAPTURE(int(side));
            Net16 net;
            for (int k = 0; k < 3; ++k)
                for (double& c : net.c[k]) c = random.uniform(-1, 1);
            const SideCrease crease{side, sharpness};
            for (int sample = 0; sample < 20; ++sample) {
                double x = random.uniform(), y = random.uniform();
                // Near the crease, where the pieces are, and on it.
                const double near = sample == 0 ? 0 : std::exp2(-random.uniform(0, 9)) * random.uniform();
                (side == 0 || side == 2 ? y : x) = side == 0 || side == 3 ? near : 1 - near;
                const Vec3d closed = regular_position(net, crease, x, y);
                const auto basis = [&](int axis, double at) {
                    return std::array{regular_basis(crease, axis, at), regular_basis(crease, axis, at, 1),
                                      regular_basis(crease, axis, at, 2)};
                };
                const std::array<Weights4, 3> wx = basis(0, x), wy = basis(1, y);
                double sum_d1 = 0, sum = 0;
                for (int i = 0; i < 4; ++i) sum += wx[0][i] + wy[0][i], sum_d1 += wx[1][i] + wy[1][i];
                CHECK(std::abs(sum - 2) < 1e-13);
                CHECK(std::abs(sum_d1) < 1e-10);
                const auto value = [&](const Weights4& in_x, const Weights4& in_y) {
                    Vec3d result(0);
                    for (int i = 0; i < 16; ++i)
                        for (int k = 0; k < 3; ++k) result[k] += in_x[i % 4] * in_y[i / 4] * net.c[k][i];
                    return result;
                };
                CHECK(glm::length(value(wx[0], wy[0]) - closed) < 1e-13);
                // Derivatives: by steps into the cell.
                const double step_x = x < 0.5 ? 1e-7 : -1e-7, step_y = y < 0.5 ? 1e-7 : -1e-7;
                const std::array<Weights4, 3> next_x = basis(0, x + step_x), next_y = basis(1, y + step_y);
                for (int d = 1; d <= 2; ++d) {
                    CAPTURE(d);
                    const Vec3d by_x = (value(next_x[d - 1], wy[0]) - value(wx[d - 1], wy[0])) / step_x,
                                by_y = (value(wx[0], next_y[d - 1]) - value(wx[0], wy[d - 1])) / step_y;
                    CHECK(glm::length(by_x - value(wx[d], wy[0])) < 1e-2 * (1 + glm::length(by_x)));
                    CHECK(glm::length(by_y - value(wx[0], wy[d])) < 1e-2 * (1 + glm::length(by_y)));
                }
                // Ten steps of the curve across make every crease smooth; then it is an ordinary one.
                const bool across_y = crease.axis() == 1, far = crease.far();
                double t = far ? 1 - (across_y ? y : x) : (across_y ? y : x), left = sharpness;
                std::array<Weights4, 4> points{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
                for (int step = 0; step < 10; ++step) {
                    const double weight = std::min(left, 1.0);
                    const std::size_t upper = t >= 0.5 ? 1 : 0;
                    for (std::size_t j = 0; j < 4; ++j) {
                        const double p0 = points[0][j], p1 = points[1][j], p2 = points[2][j], p3 = points[3][j];
                        const double on = weight * p1 + (1 - weight) * (p0 + 6 * p1 + p2) / 8;
                        const double finer[5] = {(p0 + p1) / 2, on, (p1 + p2) / 2, (p1 + 6 * p2 + p3) / 8,
                                                 (p2 + p3) / 2};
                        for (std::size_t i = 0; i < 4; ++i) points[i][j] = finer[i + upper];
                    }
                    t = 2 * t - static_cast<double>(upper);
                    left = upper != 0 ? 0 : std::max(left - 1, 0.0);
                }
                Weights4 across{};
                for (std::size_t i = 0; i < 4; ++i)
                    for (std::size_t j = 0; j < 4; ++j) across[far ? 3 - j : j] += cubic_basis(t)[i] * points[i][j];
                const Vec3d tends_to = across_y ? value(cubic_basis(x), across) : value(across, cubic_basis(y));
                CHECK(glm::length(tends_to - closed) < 1e-13);
            }
        }
}

TEST_CASE("Loop patches: a crease vertex gets the mean normal of both sides") {
    // A roof: the ridge is sharp, so that its normal must point straight up.
    ControlMeshData data = test::grid(4, true);
    for (Vec3d& p : data.positions) p = {p.x - 2, p.y, -std::abs(p.x - 2)};
    for (std::uint32_t y = 0; y < 4; ++y) data.creases.push_back({5 * y + 2, 5 * y + 7, 10.0f});
    const ControlMesh mesh = ControlMesh::build(data);
    const LoopPatches patches(mesh);
    int met = 0;
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f)
        for (std::uint32_t x = 0; x <= 4; ++x)
            for (std::uint32_t y = 0; x + y <= 4; ++y) {
                const SurfacePoint p = patches.vertex(mesh.face_halfedge(FaceId(f)), {x, y}, 2);
                if (std::abs(p.position.x) > 1e-12) continue;
                CHECK(p.position.z == doctest::Approx(0));
                CHECK(glm::length(p.normal - Vec3d(0, 0, 1)) < 1e-12);
                ++met;
            }
    CHECK(met > 0);
}

TEST_CASE("normals of flat rings point outward, also where there is no tangent plane") {
    const double around = 2 * std::acos(-1.0);
    const auto check = [](detail::CornerRing ring) {
        CAPTURE(name(ring.scheme));
        CAPTURE(ring.size());
        for (ring.cell = 0; ring.cell < ring.faces(); ++ring.cell) {
            const SurfacePoint point = ring.limit();
            CHECK(point.normal.z == doctest::Approx(1).epsilon(1e-9));
            const bool corner = is_sharp(ring.sharpness);
            if (!corner) CHECK(glm::cross(point.du, point.dv).z > 0);
            if (corner) CHECK(point.position == ring.centre);
        }
    };
    for (const SchemeKind scheme : {SchemeKind::catmull_clark, SchemeKind::loop})
        for (const int n : {3, 4, 5, 6, 7, 8, 9, 12, 16, 25, 40}) {
            const auto both = [&](detail::CornerRing ring) {
                check(ring);
                ring.sharpness = k_sharpness_infinity;
                check(ring);
            };
            both(flat_ring(scheme, n, around, false, {}));
            for (const double opening : {3.0, 5.0}) both(flat_ring(scheme, n, opening, true, {}));
            both(flat_ring(scheme, n, around, false, {n / 3}));
            for (int k = 1; k < n; k += 2) both(flat_ring(scheme, n, around, false, {n / 3, (n / 3 + k) % n}));
            check(flat_ring(scheme, n, around, false, {0, 1, n - 1}));
            check(flat_ring(scheme, n, 3, true, {1}));
        }
}

TEST_CASE("patch trees that are forgotten between batches grow again, bit for bit, and take little memory") {
    const ControlMesh mesh = ControlMesh::build(test::triangle_torus(32));
    const QuadPatches kept(mesh), forgotten(mesh);
    std::vector<Vec3d> first(mesh.halfedge_count()), again(mesh.halfedge_count());
    const auto at = [](const QuadPatches& patches, std::uint32_t h) {
        // Towards both irregular corners of the cell.
        return patches.frame(HalfedgeId(h), 1.0 / 32, 1.0 / 32).position +
               patches.frame(HalfedgeId(h), 31.0 / 32, 31.0 / 32).position;
    };
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) first[h] = at(kept, h);
    CHECK(kept.forgettable_bytes() > 2 * forgotten.bytes_to_keep());
    std::uint64_t most = 0, before = 0;
    int times = 0;
    RunContext watch;
    watch.progress = [&](std::string_view, double) {
        const std::uint64_t now = forgotten.memory_bytes();
        times += now < before;
        before = now;
        most = std::max(most, now);
        return true;
    };
    detail::for_each_batch(&forgotten, mesh.halfedge_count(), 16, watch, "test", 0, 1,
                           [&](std::uint32_t h) { again[h] = at(forgotten, h); });
    CHECK(times > 1);
    CHECK(most < 2 * forgotten.bytes_to_keep());
    CHECK(test::same_bytes(first, again));
}

TEST_CASE("the patch tree refuses what does not fit into memory") {
    const ControlMesh mesh = test::random_patch_mesh<QuadFamily>(2);
    RunContext little;
    little.max_memory_bytes = 1000;
    CHECK_THROWS_WITH_AS(QuadPatches(mesh, little), doctest::Contains("the limit is"), Error);
}

TEST_CASE_TEMPLATE("[inv1] a hierarchy whose limits come from patches has the mesh of one whose limits come from rules",
                   Family, QuadFamily, LoopFamily) {
    constexpr SchemeKind scheme = std::is_same_v<Family, LoopFamily> ? SchemeKind::loop : SchemeKind::catmull_clark;
    for (const std::uint64_t seed : test::seeds(8)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_patch_mesh<Family>(seed);
        Hierarchy by_rules = make_hierarchy(mesh, name(scheme));
        Hierarchy by_patches =
            make_hierarchy(mesh, name(scheme), {.limit_positions = std::make_shared<LimitSurface>(mesh, scheme)});
        Random random(seed);
        test::random_changes(by_rules, 10, 8, random, [] {});
        by_patches.load(by_rules.saved());
        const HierarchyMesh expected = by_rules.to_mesh({.normals = true}),
                            found = by_patches.to_mesh({.normals = true});
        CHECK(found.sites == expected.sites);
        CHECK(found.mesh.face_vertices == expected.mesh.face_vertices);
        CHECK(test::same_bytes(found.mesh.normals, expected.mesh.normals));
        double worst = 0;
        for (std::size_t v = 0; v < expected.sites.size(); ++v)
            worst = std::max(worst, glm::length(found.mesh.positions[v] - expected.mesh.positions[v]));
        // Both round at every level: some thirty last bits.
        CHECK(worst <= 4e-15 * bounding_box(mesh.positions()).diagonal());
        CHECK(test::same_bytes(by_patches.to_mesh({.positions = MeshPositions::finest}).mesh.positions,
                               by_rules.to_mesh({.positions = MeshPositions::finest}).mesh.positions));
    }
}

TEST_CASE("[bad-input] a limit surface refuses points that it does not have") {
    const ControlMesh cube = load_control_mesh(TETRAKIS_SOURCE_DIR "/data/cube.obj");
    const ControlMesh tetrahedron = load_control_mesh(TETRAKIS_SOURCE_DIR "/data/tetrahedron.obj");
    const LimitSurface quads(cube, SchemeKind::catmull_clark), triangles(tetrahedron, SchemeKind::loop);
    const HalfedgeId h(0);
    CHECK_THROWS_AS(static_cast<void>(quads.evaluate(HalfedgeId(999), 0.5, 0.5)), Error);
    CHECK_THROWS_AS(static_cast<void>(quads.evaluate(h, 2, 0)), Error);
    CHECK_THROWS_AS(static_cast<void>(quads.evaluate(h, std::nan(""), 0)), Error);
    CHECK_THROWS_AS(static_cast<void>(triangles.evaluate(h, 0.75, 0.75)), Error);
    CHECK_THROWS_AS(static_cast<void>(triangles.evaluate(HalfedgeId(1), 0, 0)), Error);
    CHECK_THROWS_AS(static_cast<void>(quads.vertex({h, {3, 0}, 1})), Error);
    Vec3d out;
    const Site beyond{h, {0, 0}, k_max_level + 1};
    CHECK_THROWS_AS(quads.positions({&beyond, 1}, {&out, 1}), Error);
    CHECK(glm::length(quads.evaluate(h, 1, 1).position - quads.vertex({h, {1, 1}, 0}).position) < 1e-14);
}

TEST_CASE("[inv9] what rounding adds to points far from the origin and deep in the tree is below what bounds allow") {
    for (const std::uint64_t seed : test::seeds(6)) {
        CAPTURE(seed);
        const auto compare = [&]<class Family>(Family, SchemeKind scheme) {
            const ControlMesh here = test::random_patch_mesh<Family>(seed);
            ControlMeshData moved = here.data();
            const Vec3d by(1e6, -2e6, 3e6);
            for (Vec3d& p : moved.positions) p += by;
            const ControlMesh there = ControlMesh::build(std::move(moved));
            const LimitSurface a(here, scheme), b(there, scheme);
            const double most = detail::surface_rounding(there);
            Random random(seed);
            std::vector<Site> sites;
            for (int i = 0; i < 200; ++i) {
                const auto level = static_cast<std::uint8_t>(20 + random.below(9));
                const auto near = [&] { return static_cast<std::uint32_t>(random.below(4)); };
                const HalfedgeId root(static_cast<std::uint32_t>(random.below(here.halfedge_count())));
                sites.push_back({std::is_same_v<Family, LoopFamily> ? here.face_halfedge(here.face(root)) : root,
                                 {near(), near()},
                                 level});
            }
            std::vector<Vec3d> p(sites.size()), q(sites.size());
            a.positions(sites, p);
            b.positions(sites, q);
            for (std::size_t i = 0; i < sites.size(); ++i) CHECK(glm::length(p[i] + by - q[i]) <= most);
        };
        compare(QuadFamily{}, SchemeKind::catmull_clark);
        compare(LoopFamily{}, SchemeKind::loop);
    }
}

TEST_SUITE_END();
