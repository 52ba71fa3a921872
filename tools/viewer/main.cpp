#include "../tetrakis/camera_path.hpp"
#include "../tetrakis/console.hpp"
#include "../tetrakis/files.hpp"
#include "../tetrakis/height_input.hpp"
#include "../tetrakis/run_options.hpp"
#include "gpu_terrain.hpp"
#include "window.hpp"

#include "../../eval/io/png.hpp"
#include "../../eval/lod/terrain_surface.hpp"
#include "../../eval/lod/view.hpp"
#include "../../hier/base/error.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>
#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrakis::viewer {
namespace {

struct ViewerOptions {
    cli::HeightInput heights;
    std::filesystem::path path, screenshot;
    std::uint32_t leaves = 200'000, frames = 120;
    double pixels = 1;
    bool wireframe = false;
    RenderOptions size;
    cli::RunOptions run;

    std::vector<cli::CameraPlace> flight(const HeightGrid& grid) const {
        return path.empty() ? circle(grid, frames, cli::Circle::fly) : cli::read_camera_path(path, frames);
    }
    lod::Camera camera(const cli::CameraPlace& place) const {
        return place.lod_camera(static_cast<std::uint32_t>(size.width), static_cast<std::uint32_t>(size.height));
    }
};

/// A terrain, its view, and the view's buffers on the graphics card.
class Scene {
  public:
    Scene(const lod::TerrainSurface& surface, std::uint32_t max_leaves)
        : surface_(surface), view_(surface, {.max_leaves = max_leaves}), gpu_(view_) {
        const HeightGrid& grid = surface.grid();
        const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
        box_.add(Vec3d(grid.origin, *low));
        box_.add(Vec3d(grid.origin + Vec2d(grid.columns - 1, 1.0 - grid.rows) * grid.spacing, *high));
    }

    void update(const lod::Camera& camera, const lod::Budget& budget) {
        if (glm::length(camera.eye - view_.origin()) > k_origin_reach * surface_.grid().spacing.x)
            view_.set_origin(camera.eye);
        const cli::Stopwatch watch;
        last = view_.update(camera, budget);
        milliseconds = 1000 * watch.seconds();
        bytes = gpu_.upload(last, camera.eye);
    }
    void draw(const lod::Camera& camera, const Lights& lights, bool wireframe) const {
        const double farthest =
            glm::length(glm::max(glm::abs(box_.lower - camera.eye), glm::abs(box_.upper - camera.eye)));
        const double nearest = std::max(k_nearest_clearance * clearance(camera.eye), k_least_depth_ratio * farthest);
        gpu_.draw({camera, nearest, farthest, lights, wireframe});
    }

    /// Of the last update.
    lod::Update last;
    double milliseconds = 0;
    std::uint64_t bytes = 0;

  private:
    // In samples: floats are then exact to 2^-14 of a sample's distance to the next one.
    static constexpr double k_origin_reach = 1024;
    // The nearest depth drawn, of the height above the ground: slopes up to 80 degrees are then farther away.
    static constexpr double k_nearest_clearance = 0.1;
    // Below this, a depth buffer of 24 bits does not tell what is far away apart.
    static constexpr double k_least_depth_ratio = 1e-5;

    double clearance(const Vec3d& eye) const {
        if (const auto ground = surface_.at({eye.x, eye.y})) return std::abs(eye.z - ground->height);
        return glm::length(glm::max(glm::max(box_.lower - eye, eye - box_.upper), 0.0));
    }

    const lod::TerrainSurface& surface_;
    Box3d box_;
    lod::View view_;
    GpuTerrain gpu_;
};

/// Turns the camera with the mouse and moves it by the keys, for as long as the last frame took. It stays above ground.
void fly(GLFWwindow* window, const lod::TerrainSurface& surface, double& speed, lod::Camera& camera) {
    constexpr double k_turn = 0.003, k_wheel = 1.2;           // radians a pixel; a step of the wheel
    constexpr double k_steepest = 1.5, k_least_height = 0.3;  // radians; samples
    const ImGuiIO& io = ImGui::GetIO();
    const Vec3d ahead = glm::normalize(camera.direction);
    double heading = std::atan2(ahead.y, ahead.x), pitch = std::asin(std::clamp(ahead.z, -1.0, 1.0));
    if (!io.WantCaptureMouse) {
        if (ImGui::IsMouseDown(0)) {
            heading -= k_turn * double{io.MouseDelta.x};
            pitch -= k_turn * double{io.MouseDelta.y};
        }
        speed *= std::pow(k_wheel, double{io.MouseWheel});
    }
    pitch = std::clamp(pitch, -k_steepest, k_steepest);
    camera.direction = {std::cos(pitch) * std::cos(heading), std::cos(pitch) * std::sin(heading), std::sin(pitch)};
    camera.up = {0, 0, 1};
    const Vec3d right = glm::normalize(glm::cross(camera.direction, camera.up));
    const auto held = [&](int forth, int back) {
        if (io.WantCaptureKeyboard) return 0.0;
        return double(glfwGetKey(window, forth) == GLFW_PRESS) - double(glfwGetKey(window, back) == GLFW_PRESS);
    };
    camera.eye += speed * double{io.DeltaTime} *
                  (held(GLFW_KEY_W, GLFW_KEY_S) * camera.direction + held(GLFW_KEY_D, GLFW_KEY_A) * right +
                   held(GLFW_KEY_E, GLFW_KEY_Q) * camera.up);
    if (const auto ground = surface.at({camera.eye.x, camera.eye.y}))
        camera.eye.z = std::max(camera.eye.z, ground->height + k_least_height * surface.grid().spacing.x);
}

/// What the panel sets.
struct Settings {
    float pixels = 1;
    int leaves = 0;
    bool wireframe = false, frozen = false, along_path = false;
};

void show_panel(const Scene& scene, double speed, int max_leaves, Settings& settings) {
    // Else numbers typed in (Ctrl and a click) may be out of range.
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
    const lod::Update& last = scene.last;
    ImGui::Text("%u triangles, %u splits, %u merges", last.leaves, last.splits, last.merges);
    ImGui::Text("%.3f ms an update, %llu bytes uploaded", scene.milliseconds,
                static_cast<unsigned long long>(scene.bytes));
    ImGui::Text(last.complete ? "errors up to %.2f pixels" : "more to do than an update's time", last.pixel_error);
    ImGui::Text("%.0f frames a second, speed %.3g", double{ImGui::GetIO().Framerate}, speed);
    ImGui::TextDisabled("drag: look; W A S D E Q: move; wheel: speed");
    ImGui::End();
}

/// Dear ImGui, for as long as a window has it.
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

void show(const ViewerOptions& options, const lod::TerrainSurface& surface) {
    constexpr double k_milliseconds = 4;    // of an update
    constexpr double k_crossing_time = 20;  // seconds, at the speed of the start
    const HeightGrid& grid = surface.grid();
    const std::vector<cli::CameraPlace> path = options.flight(grid);
    const Window window(options.size.width, options.size.height, Window::Shown::yes);
    const Panels panels(window);
    Scene scene(surface, options.leaves);
    Settings settings{static_cast<float>(options.pixels), static_cast<int>(options.leaves), options.wireframe};
    lod::Camera camera = options.camera(path.front());
    const Lights lights = lights_of(camera);
    double speed = grid.columns * grid.spacing.x / k_crossing_time;
    std::size_t frame = 0;
    while (glfwWindowShouldClose(window) == GLFW_FALSE) {
        glfwPollEvents();
        int width = 0, height = 0;
        glfwGetFramebufferSize(window, &width, &height);
        if (width == 0 || height == 0) {  // an icon
            glfwWaitEvents();
            continue;
        }
        Panels::begin();
        if (settings.along_path)
            camera = options.camera(path[++frame % path.size()]);
        else
            fly(window, surface, speed, camera);
        camera.width = static_cast<std::uint32_t>(width);
        camera.height = static_cast<std::uint32_t>(height);
        if (!settings.frozen)
            scene.update(camera, {.pixel_error = double{settings.pixels},
                                  .leaves = static_cast<std::uint32_t>(settings.leaves),
                                  .milliseconds = k_milliseconds});
        show_panel(scene, speed, static_cast<int>(options.leaves), settings);
        scene.draw(camera, lights, settings.wireframe);
        Panels::draw();
        glfwSwapBuffers(window);
    }
}

void take_screenshot(const ViewerOptions& options, const lod::TerrainSurface& surface) {
    const std::vector<cli::CameraPlace> path = options.flight(surface.grid());
    const Window window(options.size.width, options.size.height, Window::Shown::no);
    Scene scene(surface, options.leaves);
    for (const cli::CameraPlace& place : path)
        scene.update(options.camera(place), {.pixel_error = options.pixels, .leaves = options.leaves});
    const lod::Camera camera = options.camera(path.back());
    write_png(options.screenshot, picture_of(options.size.width, options.size.height,
                                             [&] { scene.draw(camera, lights_of(camera), options.wireframe); }));
}

void run(const ViewerOptions& options) {
    cli::OutputFiles outputs;
    outputs.add(cli::OutputFiles::Kind::picture, "--screenshot", options.screenshot);
    outputs.check({options.heights.path, options.path});
    cli::Run process(options.run);
    std::vector<std::string> warnings;
    const lod::TerrainSurface surface(options.heights.load(process, warnings), process.context());
    process.end_progress();
    cli::print_warnings(warnings);
    if (options.screenshot.empty())
        show(options, surface);
    else
        take_screenshot(options, surface);
}

void add_options(CLI::App& app, ViewerOptions& options) {
    options.size.width = 1280;
    options.size.height = 720;
    options.heights.add(app);
    app.add_option("--pixels", options.pixels, "Triangles whose error looks larger are split (1)")
        ->type_name("E")
        ->check(cli::number_check("a positive number", [](double value) { return value > 0; }));
    app.add_option("--budget", options.leaves, "Most triangles (200000)")
        ->type_name("N")
        ->check(CLI::Range(1u, 100'000'000u).description(""));
    app.add_option("--path", options.path, "Cameras to fly along, as tetrakis lod has them; default: once around")
        ->type_name("CAMERA.json");
    app.add_option("--frames", options.frames, "Of that flight (120)")
        ->type_name("N")
        ->check(CLI::Range(1u, 1'000'000u).description(""));
    app.add_option("--screenshot", options.screenshot, "Fly along it unseen, write the last frame, and end")
        ->type_name("PNG");
    app.add_flag("--wireframe", options.wireframe, "Draw the edges of the triangles, too");
    cli::add_size_option(app, options.size);
    options.run.add_threads(app);
    options.run.add_max_memory(app);
    app.footer("Example:\n  tetrakis_viewer data/island.png --scale 0.1 --spacing 40");
}

}  // namespace
}  // namespace tetrakis::viewer

int main(int argc, char** argv) {
    using namespace tetrakis;
    CLI::App app("tetrakis_viewer: flies over a height grid with view-dependent LOD", "tetrakis_viewer");
    viewer::ViewerOptions options;
    viewer::add_options(app, options);
    cli::ExitCode code = cli::ExitCode::failure;
    try {
        app.parse(argc, argv);
        viewer::run(options);
        return 0;
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : static_cast<int>(cli::ExitCode::usage);
    } catch (const cli::UsageError& error) {
        cli::print_error(error.what());
        code = cli::ExitCode::usage;
    } catch (const cli::InputError& error) {
        cli::print_error(error.what());
        code = cli::ExitCode::bad_input;
    } catch (const std::exception& error) {
        cli::print_error(error.what());
    }
    return static_cast<int>(code);
}
