#include "../../eval/render/render.hpp"

#include "../../eval/tessellate/shading_normals.hpp"
#include "../kit/input_helpers.hpp"
#include "../kit/meshes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

using namespace tetrakis;

TEST_SUITE_BEGIN("eval");

namespace {

int channel(const Image& image, int x, int y, int c) {
    return image.rgb[3 * (static_cast<std::size_t>(y) * image.width + x) + c];
}

RenderOptions plain(int width, int height) {
    RenderOptions options;
    options.width = width;
    options.height = height;
    options.ground = false;
    options.occlusion_samples = 0;
    options.camera = Camera{.eye = {0.5, 0.5, 4}, .target = {0.5, 0.5, 0}};
    return options;
}

TriangleMesh cube() {
    TriangleMesh mesh;
    for (int i = 0; i < 8; ++i) mesh.positions.push_back({i & 1, i >> 1 & 1, i >> 2});
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    for (const Vec3d& p : mesh.positions) mesh.normals.push_back(glm::normalize(p - Vec3d(0.5)));
    return mesh;
}

}  // namespace

TEST_CASE("a sphere covers the pixels that geometry says") {
    const TriangleMesh sphere = shapes::sphere(60, 120, Vec3d(0), 1.0);
    RenderOptions options = plain(300, 200);
    options.camera = Camera{.eye = {0, 0, 5}, .target = {0, 0, 0}};
    const Image image = render(sphere, options);
    int covered = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 300; ++x) covered += channel(image, x, y, 0) > channel(image, x, y, 2) + 10 ? 1 : 0;
    // The silhouette cone has half angle asin(1/5); the picture's half height is tan 15 degrees.
    const double radius = 100 * std::tan(std::asin(0.2)) / std::tan(std::numbers::pi / 12);
    CHECK(covered == doctest::Approx(std::numbers::pi * radius * radius).epsilon(0.02));
    CHECK(channel(image, 150, 100, 0) > 60);
}

TEST_CASE("a fitted camera sees all points, and the tightest side keeps the margin") {
    std::mt19937_64 random(12);
    std::normal_distribution<double> normal;
    for (const double aspect : {0.5, 1.0, 2.4})
        for (const Vec3d& up : {Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(1, 1, 0)}) {
            std::vector<Vec3d> points(50);
            for (Vec3d& p : points)
                p = Vec3d(7, -3, 1000) + Vec3d(3, 1, 0.2) * Vec3d(normal(random), normal(random), normal(random));
            ViewDirection view;
            view.up = up;
            const Camera camera = fit_camera(points, aspect, view);
            const Vec3d forward = glm::normalize(camera.target - camera.eye);
            const Vec3d right = glm::normalize(glm::cross(forward, camera.up)), above = glm::cross(right, forward);
            const double tan_v = std::tan(camera.vertical_fov_degrees * std::numbers::pi / 360);
            double widest = 0, highest = 0;
            for (const Vec3d& p : points) {
                const double z = glm::dot(p - camera.eye, forward);
                REQUIRE(z > 0);
                widest = std::max(widest, std::abs(glm::dot(p - camera.eye, right)) / (z * tan_v * aspect));
                highest = std::max(highest, std::abs(glm::dot(p - camera.eye, above)) / (z * tan_v));
            }
            CHECK(std::max(widest, highest) == doctest::Approx(1 - view.margin).epsilon(1e-6));
        }
}

TEST_CASE("smooth shading keeps sharp edges and takes smooth normals as they are") {
    const TriangleMesh box = cube();
    const auto sharp = detail::corner_normals(box, 40);
    for (std::size_t t = 0; t < box.triangles.size(); ++t)
        for (const Vec3f& n : sharp[t]) CHECK(glm::length(Vec3d(n) - detail::face_normal(box, t)) < 1e-6);
    TriangleMesh sphere = shapes::sphere(30, 60, Vec3d(5), 2.0);
    const auto smooth = detail::corner_normals(sphere, 40);
    std::vector<Vec3d> exact = sphere.normals;
    sphere.normals.clear();
    const auto estimated = detail::corner_normals(sphere, 40);
    for (std::size_t t = 0; t < sphere.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f n(exact[sphere.triangles[t][k]]);
            CHECK(smooth[t][k] == n);
            CHECK(glm::length(estimated[t][k] - n) < 0.02f);
        }
}

TEST_CASE("[inv10] the thread count changes no byte of a picture") {
    const TriangleMesh mesh = shapes::sphere(12, 20, Vec3d(3), 1.0);
    RenderOptions options;
    options.width = 120;
    options.height = 80;
    options.wireframe = true;
    std::vector<std::uint8_t> first;
    for (const int threads : {1, 2}) {
        const Image image = render(mesh, options, test::with_thread_count(threads));
        if (threads == 1) first = image.rgb;
        CHECK(image.rgb == first);
    }
}

TEST_CASE("[bad-input] pictures that cannot be drawn") {
    const TriangleMesh good = shapes::octahedron();
    const auto refused = [](const TriangleMesh& mesh, const RenderOptions& options) {
        return test::error_of([&] { render(mesh, options); }).code() == ErrorCode::invalid_input;
    };
    const auto with = [](auto change) {
        RenderOptions options = plain(20, 20);
        change(options);
        return options;
    };
    const std::vector<float> three(3);
    CHECK(refused(TriangleMesh{}, plain(20, 20)));
    CHECK(refused(good, plain(0, 20)));
    CHECK(refused(good, plain(20, 1'000'000)));
    CHECK(refused(good, with([](auto& o) { o.supersampling = 0; })));
    CHECK(refused(good, with([](auto& o) { o.occlusion_samples = -1; })));
    CHECK(refused(good, with([&](auto& o) { o.triangle_values = three; })));
    CHECK(refused(good, with([](auto& o) { o.camera->eye = o.camera->target; })));
    CHECK(refused(good, with([](auto& o) { o.camera->up = Vec3d(0); })));
    CHECK(refused(good, with([](auto& o) { o.camera->vertical_fov_degrees = 180; })));
    for (const double margin : {1.0, 1.5, -0.1, double{NAN}})
        CHECK(refused(good, with([&](auto& o) {
                          o.camera.reset();
                          o.view.margin = margin;
                      })));
    CHECK(refused(good, with([](auto& o) { o.surface_colour.g = NAN; })));
    CHECK(refused(good, with([](auto& o) { o.background_top.b = 1.5f; })));
    CHECK(refused(good, with([](auto& o) { o.wire_pixels = NAN; })));
    CHECK(refused(good, with([](auto& o) { o.highest_value = INFINITY; })));
    RunContext negative;
    negative.threads = -1;
    CHECK(test::error_of([&] { render(good, plain(20, 20), negative); }).code() == ErrorCode::invalid_input);
    TriangleMesh dangling = good;
    dangling.triangles[0][0] = 77;
    CHECK(refused(dangling, plain(20, 20)));
    // Looking straight along up, or at a single point, is no fault.
    RenderOptions options = plain(20, 20);
    options.camera->eye = {0, 5, 0};
    options.camera->target = {0, 0, 0};
    CHECK(render(good, options).rgb.size() == 1200);
    options.camera.reset();
    const Image fitted = render(good, options);
    TriangleMesh unused = good;  // a vertex of no triangle is not looked at
    unused.positions.emplace_back(1000, 0, 0);
    CHECK(render(unused, options).rgb == fitted.rgb);
    // The legend's font has printable ASCII alone.
    const std::vector<float> values(good.triangles.size(), 1);
    options.triangle_values = values;
    options.legend_title = "a\tb";
    const Image odd = render(good, options);
    options.legend_title = "a?b";
    CHECK(render(good, options).rgb == odd.rgb);
    options.triangle_values = {};
    TriangleMesh point;
    point.positions = {{1, 1, 1}};
    point.triangles = {{0, 0, 0}};
    CHECK(render(point, options).rgb.size() == 1200);
}

TEST_SUITE_END();
