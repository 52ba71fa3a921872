#include "../../eval/lod/view.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../eval/render/render.hpp"
#include "../../eval/surface/height_image.hpp"

#include "../kit/cli.hpp"
#include "../kit/scratch_dir.hpp"

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <string>
#include <vector>

using namespace tetrakis;

namespace {

struct Place {
    Vec3d eye, target;
};

// It comes from so far away that floats about the first eye would not do: the viewer moves its origin on the way.
const std::vector<Place> k_flight = {{{-2e9, -2560, 4e7}, {2560, -2560, 0}},
                                     {{2560, -9000, 1500}, {2560, -2560, 0}},
                                     {{1800, -5600, 600}, {2560, -2560, 100}},
                                     {{3500, -5900, 1100}, {2500, -2560, 100}}};
constexpr int k_width = 320, k_height = 240;
constexpr double k_degrees = 50;
constexpr double k_pixels = 12;  // coarse, so that what morphing moves is seen
// Slopes up to 37 degrees: render()'s key light, at 49 degrees, casts no shadows, which the viewer does not have.
constexpr double k_scale = 0.05, k_spacing = 40;

/// The mesh as it is shown after the flight. Its normals are the surface's own, not those of the view's vertices.
TriangleMesh shown_mesh() {
    const lod::TerrainSurface surface(
        load_height_grid(cli::data("island.png"), {.scale = k_scale, .spacing = Vec2d(k_spacing)}));
    lod::View view(surface);
    lod::Update update;
    for (const Place& place : k_flight)
        update = view.update({.eye = place.eye,
                              .direction = place.target - place.eye,
                              .vertical_fov = k_degrees * M_PI / 180,
                              .width = k_width,
                              .height = k_height},
                             {.pixel_error = k_pixels});
    TriangleMesh mesh = view.mesh();  // its triangles are in the order of the view's
    mesh.triangle_normals = mesh.triangles;
    auto triangle = mesh.triangles.begin();
    for (const lod::Triangle& shown : view.triangles()) {
        if (shown == lod::Triangle{}) continue;
        for (std::size_t k = 0; k < 3; ++k)
            mesh.positions[(*triangle)[k]] =
                view.origin() +
                shown_position(view.vertices()[shown[k]], k_flight.back().eye - view.origin(), update.morph_scale);
        ++triangle;
    }
    return mesh;
}

}  // namespace

TEST_CASE("viewer: after a flight it shows what Embree draws of the same mesh") {
    const ScratchDir scratch;
    const std::string path = (scratch / "path.json").string(), seen = (scratch / "seen.png").string(),
                      expected = (scratch / "expected.png").string();
    nlohmann::json cameras;
    for (const auto& [eye, target] : k_flight)
        cameras.push_back(
            {{"eye", {eye.x, eye.y, eye.z}}, {"target", {target.x, target.y, target.z}}, {"fov_degrees", k_degrees}});
    spill(path, cameras.dump());
    const ProcessResult result =
        run_process({"/usr/bin/env",    "LIBGL_ALWAYS_SOFTWARE=1",
                     TETRAKIS_XVFB_RUN, "-a",
                     TETRAKIS_VIEWER,   cli::data("island.png"),
                     "--scale",         std::to_string(k_scale),
                     "--spacing",       std::to_string(k_spacing),
                     "--pixels",        std::to_string(k_pixels),
                     "--path",          path,
                     "--frames",        std::to_string(k_flight.size()),
                     "--size",          std::to_string(k_width) + "x" + std::to_string(k_height),
                     "--screenshot",    seen});
    CAPTURE(result.err);
    REQUIRE(result.code == 0);

    RenderOptions options;
    options.width = k_width;
    options.height = k_height;
    options.camera = Camera{k_flight.back().eye, k_flight.back().target, Vec3d(0, 0, 1), k_degrees};
    options.ground = false;
    options.occlusion_samples = 0;
    write_png(expected, render(shown_mesh(), options));

    const HeightImage a = load_height_image(seen), b = load_height_image(expected);
    REQUIRE(a.width == k_width);
    REQUIRE(a.height == k_height);
    constexpr float k_sky = 0.86f;  // the ground is darker
    constexpr float k_same = 0.05f;
    double sum = 0, ground = 0, other_side = 0, not_same = 0;
    for (std::size_t i = 0; i < b.values.size(); ++i) {
        const float difference = std::abs(a.values[i] - b.values[i]);
        sum += double{difference};
        not_same += difference > k_same ? 1 : 0;
        ground += b.values[i] < k_sky ? 1 : 0;
        other_side += (a.values[i] < k_sky) != (b.values[i] < k_sky) ? 1 : 0;
    }
    // Mesa's software draws 0.0015, 0.17 % and none. Without morphing these are 0.0025, 0.8 % and 0.4 %; without a last
    // range of each update 0.005, 2 % and 2 %; from the camera before 0.009, 3 % and 5 %.
    const auto pixels = static_cast<double>(b.values.size());
    CHECK(ground > pixels / 3);
    CHECK(sum < 0.002 * pixels);
    CHECK(other_side < 0.004 * pixels);  // the two average 4 and 9 samples of a pixel
    CHECK(not_same < 0.001 * pixels);
}
