#include "../../eval/surface/quad_patches.hpp"
#include "../../eval/tessellate/patch_batches.hpp"

#include "../contract/golden.hpp"
#include "../kit/quad_test_mesh.hpp"
#include "../kit/shared_data.hpp"

#include "../../hier/base/parallel.hpp"
#include "../../hier/forest/corner_cell.hpp"
#include "../../hier/mesh/obj_reader.hpp"
#include "../../refine/adaptive/closure.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

using namespace tetrakis;

namespace {

double diagonal(const ControlMesh& mesh) { return bounding_box(mesh.positions()).diagonal(); }

bool same_bits(const Vec3d& a, const Vec3d& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Lattice points of every root that is part of the surface: all of levels 0 to 2, `more` random ones of levels 3
/// and 4.
std::vector<Site> some_sites(const ControlMesh& mesh, std::uint64_t seed, int more) {
    test::Random random(seed);
    std::vector<Site> sites;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) {
        if (mesh.is_hole(mesh.face(HalfedgeId(h)))) continue;
        for (std::uint32_t y = 0; y <= 4; ++y)
            for (std::uint32_t x = 0; x <= 4; ++x) sites.push_back({HalfedgeId(h), {x, y}, 2});
        for (int i = 0; i < more; ++i) {
            const auto level = static_cast<std::uint8_t>(3 + random.below(2));
            const std::uint32_t n = (1u << level) + 1;
            sites.push_back({HalfedgeId(h), {random.below(n), random.below(n)}, level});
        }
    }
    return sites;
}

/// Largest distance between the two evaluators; the normals where the surface has a tangent plane.
struct Departure {
    double position = 0, normal = 0;
};
Departure compare(const ControlMesh& mesh, std::uint64_t seed, int more) {
    const QuadPatches patches(mesh);
    const Closure closure(mesh, SchemeKind::catmull_clark);
    const std::vector<Site> sites = some_sites(mesh, seed, more);
    std::vector<LimitPoint> limits(sites.size());
    closure.limits(sites, limits);
    Departure result;
    for (std::size_t i = 0; i < sites.size(); ++i) {
        const Site& s = sites[i];
        const SurfacePoint p = patches.vertex(s.root, s.at, s.level);
        result.position = std::max(result.position, glm::length(p.position - limits[i].position));
        result.position = std::max(result.position, glm::length(patches.limit(s.root, s.at, s.level) - p.position));
        // Surfaces folded flat have places without any direction across, which rounding decides.
        const Vec3d& a = limits[i].tangent1;
        const Vec3d& b = limits[i].tangent2;
        if (limits[i].has_tangent_plane && glm::length(glm::cross(a, b)) > 1e-6 * glm::length(a) * glm::length(b))
            result.normal = std::max(result.normal, glm::length(p.normal - limits[i].normal));
    }
    return result;
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[inv1] Catmull-Clark's patch tree gives the limits of closure, tags of all kinds included") {
    for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin})
        for (const std::uint64_t seed : test::seeds(24)) {
            CAPTURE(seed);
            CAPTURE(static_cast<int>(method));
            const ControlMesh mesh = test::random_quad_mesh(seed, method);
            const Departure off = compare(mesh, seed, 12);
            CHECK(off.position < 1e-12 * diagonal(mesh));
            // Random n-gons and bumps have places where the tangents are nearly parallel.
            CHECK(off.normal < 1e-7);
        }
}

TEST_CASE("[golden] Catmull-Clark limits and normals of the patch tree are those of the golden files") {
    const auto folder = golden::folder();
    if (!folder) return;
    int count = 0;
    for (const auto& path : golden::files(*folder, ".catmark.osd.limit.txt.gz")) {
        const std::string file = path.filename().string();
        INFO(file);
        const ControlMesh mesh = load_control_mesh(*folder / "meshes" / (file.substr(0, file.find('.')) + ".obj"));
        const QuadPatches patches(mesh);
        std::vector<SurfacePoint> ours;
        for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h)
            for (std::uint32_t i = 0; i < 9 && !mesh.is_hole(mesh.face(HalfedgeId(h))); ++i)
                ours.push_back(patches.vertex(HalfedgeId(h), {i % 3, i / 3}, 1));
        const double tolerance = 1e-9 * diagonal(mesh);
        for (const golden::Limit& limit : golden::read_limits(path)) {
            double nearest = std::numeric_limits<double>::infinity(), normal = nearest;
            for (const SurfacePoint& p : ours) {
                const double d = glm::length(p.position - limit.position);
                nearest = std::min(nearest, d);
                if (d < tolerance) normal = std::min(normal, glm::length(p.normal - limit.normal));
            }
            CHECK(nearest < tolerance);
            if (limit.normal != Vec3d(0)) CHECK(normal < (limit.iterated ? 2e-6 : 1e-9));
            ++count;
        }
    }
    CHECK(count > 1000);
}

TEST_CASE("Catmull-Clark patches: second derivatives are absent at extraordinary points alone") {
    for (const std::uint64_t seed : test::seeds(4)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_quad_mesh(seed, CreaseMethod::uniform);
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

TEST_CASE("Catmull-Clark patches: derivatives are those of finite differences") {
    int checked = 0;
    for (const CreaseMethod method : {CreaseMethod::uniform, CreaseMethod::chaikin})
        for (const std::uint64_t seed : test::seeds(8)) {
            CAPTURE(seed);
            const ControlMesh mesh = test::random_quad_mesh(seed, method);
            const QuadPatches patches(mesh);
            test::Random random(seed);
            for (std::uint32_t r = 0; r < mesh.halfedge_count(); ++r) {
                const HalfedgeId root(r);
                const double x = random.uniform(0.001, 0.999), y = random.uniform(0.001, 0.999);
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
    CHECK(checked > 500);
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
                Weights4 wx[3], wy[3];
                regular_basis(crease, x, y, wx, wy);
                double sum_d1 = 0, sum = 0;
                for (int i = 0; i < 4; ++i) sum += wx[0][i] + wy[0][i], sum_d1 += wx[1][i] + wy[1][i];
                CHECK(std::abs(sum - 2) < 1e-13);
                CHECK(std::abs(sum_d1) < 1e-10);
                Net16 cell = net;
                SideCrease left = crease;
                // Ten steps make every crease smooth; then the ordinary patch.
                for (int step = 0; step < 10; ++step) {
                    const int qx = x >= 0.5, qy = y >= 0.5;
                    x = 2 * x - qx, y = 2 * y - qy;
                    Net16 next;
                    SideCrease next_crease;
                    child_net(cell, left, qx, qy, next, next_crease);
                    cell = next, left = next_crease;
                    CHECK(glm::length(regular_position(cell, left, x, y) - closed) < 1e-13);
                }
                CHECK(!left);
            }
        }
}

TEST_CASE("Catmull-Clark patches agree from both sides of every cell side") {
    for (const std::uint64_t seed : test::seeds(12)) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_quad_mesh(seed, seed % 2 ? CreaseMethod::chaikin : CreaseMethod::uniform);
        const QuadPatches patches(mesh);
        const double tolerance = 1e-12 * diagonal(mesh);
        test::Random random(seed);
        double worst = 0;
        for (std::uint32_t r = 0; r < mesh.halfedge_count(); ++r)
            for (const CellSide side : k_cell_sides) {
                const HalfedgeId other = across(mesh, HalfedgeId(r), side);
                if (!other.valid()) continue;
                const double t = random.uniform();
                Vec2d here(0), there(0);
                switch (side) {
                    case CellSide::edge:
                        here = {t, 0}, there = {0, t};
                        break;
                    case CellSide::prev_edge:
                        here = {0, t}, there = {t, 0};
                        break;
                    case CellSide::next_cell:
                        here = {1, t}, there = {t, 1};
                        break;
                    case CellSide::prev_cell:
                        here = {t, 1}, there = {1, t};
                        break;
                }
                worst = std::max(worst, glm::length(patches.evaluate(HalfedgeId(r), here.x, here.y).position -
                                                    patches.evaluate(other, there.x, there.y).position));
            }
        CHECK(worst < tolerance);
    }
}

TEST_CASE("patch trees that are forgotten between batches grow again, bit for bit, and take little memory") {
    constexpr std::uint32_t n = 32;
    ControlMeshData data;  // a torus of triangles: six at each vertex
    for (std::uint32_t i = 0; i < n * n; ++i) {
        const double a = 2 * std::numbers::pi * (i / n) / n, b = 2 * std::numbers::pi * (i % n) / n;
        data.positions.push_back({(3 + std::cos(b)) * std::cos(a), (3 + std::cos(b)) * std::sin(a), std::sin(b)});
    }
    const auto vertex = [](std::uint32_t i, std::uint32_t j) { return i % n * n + j % n; };
    data.face_offsets = {0};
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = 0; j < n; ++j)
            for (const auto& v : {std::array{vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)},
                                  std::array{vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)}}) {
                data.face_vertices.insert(data.face_vertices.end(), v.begin(), v.end());
                data.face_offsets.push_back(static_cast<std::uint32_t>(data.face_vertices.size()));
            }
    const ControlMesh mesh = ControlMesh::build(std::move(data));
    const QuadPatches kept(mesh), forgotten(mesh);
    std::vector<Vec3d> first(mesh.halfedge_count()), again(mesh.halfedge_count());
    const auto at = [](const QuadPatches& patches, std::uint32_t h) {
        // Towards both irregular corners of the cell.
        return patches.frame(HalfedgeId(h), 1.0 / 32, 1.0 / 32).position +
               patches.frame(HalfedgeId(h), 31.0 / 32, 31.0 / 32).position;
    };
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) first[h] = at(kept, h);
    CHECK(kept.forgettable_bytes() > 2 * forgotten.bytes_to_keep());
    std::uint64_t most = 0;
    RunContext watch;
    watch.progress = [&](std::string_view, double) {
        most = std::max(most, forgotten.memory_bytes());
        return true;
    };
    detail::for_each_batch(&forgotten, mesh.halfedge_count(), 16, watch, "test", 0, 1,
                           [&](std::uint32_t h) { again[h] = at(forgotten, h); });
    CHECK(forgotten.times_forgotten() > 1);
    CHECK(most < 2 * forgotten.bytes_to_keep());
    bool same = true;
    for (std::uint32_t h = 0; h < mesh.halfedge_count(); ++h) same &= same_bits(first[h], again[h]);
    CHECK(same);
}

TEST_CASE("the patch tree refuses what does not fit into memory") {
    const ControlMesh mesh = test::random_quad_mesh(1, CreaseMethod::uniform);
    RunContext little;
    little.max_memory_bytes = 1000;
    try {
        const QuadPatches patches(mesh, little);
        CHECK(false);
    } catch (const Error& error) {
        CHECK(error.code() == ErrorCode::memory_limit);
        CHECK(std::string(error.what()).find("limit of 1000") != std::string::npos);
    }
}

TEST_SUITE_END();
