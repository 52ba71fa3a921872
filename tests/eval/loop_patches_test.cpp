#include "../../eval/surface/loop_patches.hpp"

#include "../contract/golden.hpp"
#include "../kit/loop_reference.hpp"

#include "../../hier/mesh/obj_reader.hpp"

#include <doctest/doctest.h>

#include <string>

using namespace tetrakis;

namespace {

double diagonal(const ControlMesh& mesh) { return bounding_box(mesh.positions()).diagonal(); }

double nearest(const Vec3d& p, const std::vector<Vec3d>& points) {
    double best = std::numeric_limits<double>::infinity();
    for (const Vec3d& q : points) best = std::min(best, glm::dot(p - q, p - q));
    return std::sqrt(best);
}

}  // namespace

TEST_SUITE_BEGIN("eval");

TEST_CASE("[golden] Loop limits of the patch tree are those of the golden files") {
    const auto folder = golden::folder();
    if (!folder) return;
    int meshes = 0;
    for (const auto& path : golden::files(*folder, ".loop.osd.limit.txt.gz")) {
        const std::string file = path.filename().string();
        const ControlMesh mesh = load_control_mesh(*folder / "meshes" / (file.substr(0, file.find('.')) + ".obj"));
        CAPTURE(file);
        const LoopPatches patches(mesh);
        std::vector<Vec3d> theirs, ours;
        for (const golden::Limit& limit : golden::read_limits(path)) theirs.push_back(limit.position);
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            if (mesh.is_hole(FaceId(f))) continue;
            for (std::uint32_t x = 0; x <= 4; ++x)
                for (std::uint32_t y = 0; x + y <= 4; ++y)
                    ours.push_back(patches.limit(mesh.face_halfedge(FaceId(f)), {x, y}, 2));
        }
        const double tolerance = 1e-9 * diagonal(mesh);
        double worst = 0;
        for (const Vec3d& p : theirs) worst = std::max(worst, nearest(p, ours));
        for (const Vec3d& p : ours) worst = std::max(worst, nearest(p, theirs));
        CHECK(worst < tolerance);
        ++meshes;
    }
    CHECK(meshes == 14);
}

TEST_CASE("[inv1] Loop limits are those of the uniformly refined mesh, tags and boundaries included") {
    for (std::uint32_t seed = 0; seed < 40; ++seed) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_tagged_mesh(seed);
        const LoopPatches patches(mesh);
        test::UniformLoop uniform(mesh);
        const int level = 3;
        while (uniform.level < level) uniform.step();
        const LoopPatches fine(uniform.mesh);
        double worst = 0;
        for (std::uint32_t f = 0; f < uniform.mesh.face_count(); ++f)
            for (std::uint32_t k = 0; k < 3; ++k) {
                constexpr std::array<LatticePoint, 3> corners{LatticePoint{0, 0}, {1, 0}, {0, 1}};
                const Vec3d expected = fine.limit(uniform.mesh.face_halfedge(FaceId(f)), corners[k], 0);
                const Vec3d got = patches.limit(uniform.places[f].root, uniform.places[f].corner[k], level);
                worst = std::max(worst, glm::length(got - expected));
            }
        CHECK(worst < 1e-12 * diagonal(mesh));
    }
}

TEST_CASE("Loop patches: derivatives are those of finite differences") {
    for (std::uint32_t seed = 0; seed < 12; ++seed) {
        CAPTURE(seed);
        const ControlMesh mesh = test::random_tagged_mesh(seed);
        const LoopPatches patches(mesh);
        std::mt19937 random(seed);
        std::uniform_real_distribution<double> unit(0, 1);
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            const HalfedgeId root = mesh.face_halfedge(FaceId(f));
            double x = unit(random), y = unit(random);
            if (x + y > 1) x = 1 - x, y = 1 - y;
            const double h = 1e-5, margin = 2 * h;
            if (x < margin || y < margin || x + y > 1 - margin) continue;
            // Away from the lines between patches, where third derivatives jump.
            const SurfacePoint p = patches.evaluate(root, x, y);
            const auto at = [&](double a, double b) { return patches.evaluate(root, x + a * h, y + b * h); };
            const double size = glm::length(p.duu) + glm::length(p.dvv) + glm::length(p.duv) + diagonal(mesh);
            const double tolerance = 2e-4 * size * (1 + 1 / std::min({x, y, 1 - x - y}));
            REQUIRE(p.has_second);
            CHECK(glm::length(p.du - (at(1, 0).position - at(-1, 0).position) / (2 * h)) < tolerance);
            CHECK(glm::length(p.dv - (at(0, 1).position - at(0, -1).position) / (2 * h)) < tolerance);
            CHECK(glm::length(p.duu - (at(1, 0).du - at(-1, 0).du) / (2 * h)) < tolerance);
            CHECK(glm::length(p.duv - (at(0, 1).du - at(0, -1).du) / (2 * h)) < tolerance);
            CHECK(glm::length(p.dvv - (at(0, 1).dv - at(0, -1).dv) / (2 * h)) < tolerance);
            if (glm::length(p.normal) > 0)
                CHECK(glm::dot(p.normal, glm::cross(p.du, p.dv)) ==
                      doctest::Approx(glm::length(glm::cross(p.du, p.dv))).epsilon(1e-12));
        }
    }
}

TEST_CASE("Loop patches: normals at vertices are continuous where the surface is smooth") {
    // Near a vertex with nothing sharp around it the normal tends to the vertex' own.
    int met = 0;
    for (std::uint32_t seed = 0; seed < 24; ++seed) {
        const ControlMesh mesh = test::random_tagged_mesh(seed);
        CAPTURE(seed);
        const LoopPatches patches(mesh);
        for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
            const HalfedgeId root = mesh.face_halfedge(FaceId(f));
            const VertexId v = mesh.origin(root);
            bool smooth = !mesh.is_boundary(v) && mesh.sharpness(v) == 0 && mesh.valence(v) >= 4;
            for (HalfedgeId h = root; smooth;) {
                smooth = mesh.sharpness(mesh.edge(h)) == 0;
                h = mesh.ccw_outgoing(h);
                if (h == root) break;
            }
            if (!smooth) continue;
            CAPTURE(mesh.valence(v));
            const SurfacePoint vertex = patches.vertex(root, {0, 0}, 0);
            const SurfacePoint near = patches.evaluate(root, 1e-9, 2e-9);
            CHECK(glm::length(vertex.normal) == doctest::Approx(1));
            CHECK(glm::dot(vertex.normal, near.normal) > 0.99);
            ++met;
        }
    }
    CHECK(met > 100);
}

TEST_CASE("Loop patches: a crease vertex gets the mean normal of both sides") {
    // A roof: the ridge is sharp, so that its normal must point straight up.
    ControlMeshData data;
    for (int y = 0; y <= 4; ++y)
        for (int x = -2; x <= 2; ++x) data.positions.push_back({double(x), double(y), -std::abs(double(x))});
    data.face_offsets.push_back(0);
    for (std::uint32_t y = 0; y < 4; ++y)
        for (std::uint32_t x = 0; x < 4; ++x) {
            const std::uint32_t v = y * 5 + x;
            for (const std::uint32_t i : {v, v + 1, v + 6, v, v + 6, v + 5}) data.face_vertices.push_back(i);
        }
    for (std::uint32_t i = 3; i <= data.face_vertices.size(); i += 3) data.face_offsets.push_back(i);
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

TEST_SUITE_END();
