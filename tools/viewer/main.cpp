#include "../tetrakis/command_line.hpp"
#include "../tetrakis/console.hpp"
#include "../tetrakis/files.hpp"
#include "../tetrakis/lod_scene.hpp"
#include "../tetrakis/run_options.hpp"
#include "gpu_terrain.hpp"
#include "window.hpp"

#include "../../eval/io/png.hpp"
#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/surface.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>
#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrakis::viewer {
namespace {

struct ViewerOptions {
    cli::LodInput input;
    std::filesystem::path path, screenshot;
    std::uint32_t leaves = 200'000, frames = 120;
    double pixels = 1;
    bool wireframe = false;
    RenderOptions size;
    cli::RunOptions run;

    std::vector<cli::CameraPlace> flight(const cli::LodScene& scene) const {
        return path.empty() ? circle(scene, frames, true) : cli::cameras_of(path, frames);
    }
    lod::Camera camera(const cli::CameraPlace& place) const { return place.lod_camera(size.width, size.height); }
};

/// A view of a scene with its buffers on the graphics card.
class Drawing {
  public:
    Drawing(const cli::LodScene& scene, std::uint32_t max_leaves, const Vec3d& eye)
        : scene_(scene), view_(*scene.surface, {.max_leaves = max_leaves}), gpu_(view_) {
        constexpr std::uint32_t k_places = 10'000;
        box_ = bounding_box(lod::random_places(*scene.surface, k_places));
        view_.set_origin(eye);
    }

    void update(const lod::Camera& camera, const lod::Budget& budget) {
        if (glm::length(camera.eye - view_.origin()) > k_origin_reach * clearance(camera.eye))
            view_.set_origin(camera.eye);
        const cli::Stopwatch watch;
        last = view_.update(camera, budget);
        milliseconds = 1000 * watch.seconds();
        bytes = gpu_.upload(last, camera.eye);
    }
    void draw(const lod::Camera& camera, const Lights& lights, bool wireframe) const {
        const double farthest =
            k_box_margin * glm::length(glm::max(glm::abs(box_.lower - camera.eye), glm::abs(box_.upper - camera.eye)));
        const double nearest = std::max(k_nearest_clearance * clearance(camera.eye), k_least_depth_ratio * farthest);
        gpu_.draw({camera, nearest, farthest, lights, wireframe});
    }

    /// Result, time and uploaded bytes of the last update.
    lod::Update last;
    double milliseconds = 0;
    std::uint64_t bytes = 0;

  private:
    // Relative to the clearance. Rounding to floats is then 6e-5 of the distance to the ground, a tenth of a pixel.
    static constexpr double k_origin_reach = 1000;
    // Depth of the near plane relative to the clearance: slopes up to 80 degrees are then behind it.
    static constexpr double k_nearest_clearance = 0.1;
    // Least ratio of near to far plane for which a 24-bit depth buffer still separates distant surfaces.
    static constexpr double k_least_depth_ratio = 1e-5;
    static constexpr double k_box_margin = 1.2;       // because the box contains only some points of the surface
    static constexpr double k_mesh_clearance = 1e-3;  // clearance inside a mesh's box, relative to its diameter

    /// Estimated distance of the ground.
    double clearance(const Vec3d& eye) const {
        const double to_box = glm::length(glm::max(glm::max(box_.lower - eye, eye - box_.upper), 0.0));
        return std::max(to_box, scene_.low ? std::abs(scene_.height_at(eye)) : k_mesh_clearance * scene_.size);
    }

    const cli::LodScene& scene_;
    Box3d box_;
    lod::View view_;
    GpuTerrain gpu_;
};

/// Turns the camera by the mouse and moves it by the keys, for the duration of the last frame. It stays above ground.
void fly(GLFWwindow* window, const cli::LodScene& scene, double& speed, lod::Camera& camera) {
    constexpr double k_turn = 0.003, k_wheel = 1.2;            // radians a pixel; a step of the wheel
    constexpr double k_steepest = 1.5, k_least_height = 1e-4;  // radians; of the scene's size
    const ImGuiIO& io = ImGui::GetIO();
    const Vec3d up = scene.up_at(camera.eye), ahead = glm::normalize(camera.direction);
    double pitch = std::asin(std::clamp(glm::dot(ahead, up), -1.0, 1.0)), turn = 0;
    if (!io.WantCaptureMouse) {
        if (ImGui::IsMouseDown(0)) {
            turn = k_turn * double{io.MouseDelta.x};
            pitch -= k_turn * double{io.MouseDelta.y};
        }
        speed *= std::pow(k_wheel, double{io.MouseWheel});
    }
    pitch = std::clamp(pitch, -k_steepest, k_steepest);
    Vec3d right = glm::cross(ahead, up);
    if (glm::length(right) == 0) right = glm::cross(Vec3d(up.y, up.z, up.x), up);
    right = glm::normalize(right);
    const Vec3d level = std::cos(turn) * glm::cross(up, right) + std::sin(turn) * right;
    right = glm::cross(level, up);
    camera.direction = std::cos(pitch) * level + std::sin(pitch) * up;
    camera.up = up;
    const auto held = [&](int forth, int back) {
        if (io.WantCaptureKeyboard) return 0.0;
        return double(glfwGetKey(window, forth) == GLFW_PRESS) - double(glfwGetKey(window, back) == GLFW_PRESS);
    };
    camera.eye += speed * double{io.DeltaTime} *
                  (held(GLFW_KEY_W, GLFW_KEY_S) * camera.direction + held(GLFW_KEY_D, GLFW_KEY_A) * right +
                   held(GLFW_KEY_E, GLFW_KEY_Q) * up);
    if (scene.low)
        camera.eye +=
            std::max(0.0, k_least_height * scene.size - scene.height_at(camera.eye)) * scene.up_at(camera.eye);
}

/// Settings of the panel.
struct Settings {
    float pixels = 1;
    int leaves = 0;
    bool wireframe = false, frozen = false, along_path = false;
};

void show_panel(const Drawing& drawing, double speed, int max_leaves, Settings& settings) {
    // Without AlwaysClamp, numbers typed in (Ctrl and a click) may be out of range.
    constexpr ImGuiSliderFlags k_slider = ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp;
    ImGui::Begin("tetrakis", nullptr, ImGuiWindowFlags_AlwaysAutoResize);
    ImGui::SliderFloat("pixels", &settings.pixels, 0.1f, 100.0f, "%.2f", k_slider);
    ImGui::SliderInt("triangles", &settings.leaves, 1, max_leaves, "%d", k_slider);
    ImGui::Checkbox("wireframe", &settings.wireframe);
    ImGui::SameLine();
    ImGui::Checkbox("freeze", &settings.frozen);
    ImGui::SameLine();
    ImGui::Checkbox("along the path", &settings.along_path);
    ImGui::Separator();
    const lod::Update& last = drawing.last;
    ImGui::Text("%u triangles, %u splits, %u merges", last.leaves, last.splits, last.merges);
    ImGui::Text("%.3f ms an update, %llu bytes uploaded", drawing.milliseconds,
                static_cast<unsigned long long>(drawing.bytes));
    ImGui::Text(last.complete ? "errors up to %.2f pixels" : "more to do than an update's time", last.pixel_error);
    ImGui::Text("%.0f frames a second, speed %.3g", double{ImGui::GetIO().Framerate}, speed);
    ImGui::TextDisabled("drag: look; W A S D E Q: move; wheel: speed");
    ImGui::End();
}

/// Session of Dear ImGui in a window.
class Panels {
  public:
    explicit Panels(GLFWwindow* window) {
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        ImGui_ImplGlfw_InitForOpenGL(window, true);
        ImGui_ImplOpenGL3_Init("#version 330 core");
    }
    ~Panels() {
        ImGui_ImplOpenGL3_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
    }
    Panels(const Panels&) = delete;
    Panels& operator=(const Panels&) = delete;

    static void begin() {
        ImGui_ImplOpenGL3_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
    }
    static void draw() {
        ImGui::Render();
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    }
};

void show(const ViewerOptions& options, const cli::LodScene& scene) {
    constexpr double k_milliseconds = 4;    // of an update
    constexpr double k_crossing_time = 20;  // seconds, at the speed of the start
    const std::vector<cli::CameraPlace> path = options.flight(scene);
    const Window window(options.size.width, options.size.height, Window::Shown::yes);
    const Panels panels(window);
    Drawing drawing(scene, options.leaves, path.front().eye);
    Settings settings{static_cast<float>(options.pixels), static_cast<int>(options.leaves), options.wireframe};
    lod::Camera camera = options.camera(path.front());
    const Lights lights = lights_of(camera);
    double speed = scene.size / k_crossing_time;
    std::size_t frame = 0;
    while (glfwWindowShouldClose(window) == GLFW_FALSE) {
        glfwPollEvents();
        int width = 0, height = 0;
        glfwGetFramebufferSize(window, &width, &height);
        if (width == 0 || height == 0) {  // minimised
            glfwWaitEvents();
            continue;
        }
        Panels::begin();
        if (settings.along_path)
            camera = options.camera(path[++frame % path.size()]);
        else
            fly(window, scene, speed, camera);
        camera.width = static_cast<std::uint32_t>(width);
        camera.height = static_cast<std::uint32_t>(height);
        if (!settings.frozen)
            drawing.update(camera, {.pixel_error = double{settings.pixels},
                                    .leaves = static_cast<std::uint32_t>(settings.leaves),
                                    .milliseconds = k_milliseconds});
        show_panel(drawing, speed, static_cast<int>(options.leaves), settings);
        drawing.draw(camera, lights, settings.wireframe);
        Panels::draw();
        glfwSwapBuffers(window);
    }
}

void take_screenshot(const ViewerOptions& options, const cli::LodScene& scene) {
    const std::vector<cli::CameraPlace> path = options.flight(scene);
    const Window window(options.size.width, options.size.height, Window::Shown::no);
    Drawing drawing(scene, options.leaves, path.front().eye);
    for (const cli::CameraPlace& place : path)
        drawing.update(options.camera(place), {.pixel_error = options.pixels, .leaves = options.leaves});
    const lod::Camera camera = options.camera(path.back());
    write_png(options.screenshot, picture_of(options.size.width, options.size.height,
                                             [&] { drawing.draw(camera, lights_of(camera), options.wireframe); }));
}

cli::ExitCode run(const ViewerOptions& options) {
    cli::OutputFiles outputs;
    outputs.add(cli::OutputFiles::Kind::picture, "--screenshot", options.screenshot);
    outputs.check(options.input.inputs(options.path));
    cli::Run process(options.run);
    std::vector<std::string> warnings;
    const cli::LodScene scene = options.input.load(process, warnings);
    process.end_progress();
    cli::print_warnings(warnings);
    cli::let_interrupts_end();
    if (options.screenshot.empty())
        show(options, scene);
    else
        take_screenshot(options, scene);
    return cli::ExitCode::done;
}

void add_options(cli::CommandLine line, ViewerOptions& options) {
    options.size.width = 1280;
    options.size.height = 720;
    options.input.add(line);
    line.option("--pixels", "E", options.pixels, "Triangles whose error looks larger are split (1)").positive();
    line.option("--budget", "N", options.leaves, "Most triangles (200000)").range(1u, 100'000'000u);
    line.option("--path", "CAMERA.json", options.path,
                "Cameras to fly along, as tetrakis lod has them; default: once around");
    line.option("--frames", "N", options.frames, "Of that flight (120)").range(1u, 1'000'000u);
    line.option("--screenshot", "PNG", options.screenshot, "Fly along it unseen, write the last frame, and end");
    line.flag("--wireframe", options.wireframe, "Draw the edges of the triangles, too");
    cli::add_size_option(line, options.size);
    options.run.add(line);
    line.runs([&options] { return run(options); });
}

}  // namespace
}  // namespace tetrakis::viewer

int main(int argc, char** argv) {
    using namespace tetrakis;
    cli::Program program(
        "tetrakis_viewer",
        "tetrakis_viewer: flies over a terrain, a planet or a subdivision surface with view-dependent LOD",
        "Example:\n  tetrakis_viewer data/island.png --scale 0.1 --spacing 40");
    viewer::ViewerOptions options;
    viewer::add_options(program.line(), options);
    return program.run(argc, argv);
}
