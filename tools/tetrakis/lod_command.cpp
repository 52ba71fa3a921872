#include "commands.hpp"
#include "console.hpp"
#include "files.hpp"
#include "lod_scene.hpp"
#include "report.hpp"
#include "run_options.hpp"

#include "../../eval/distance/triangle_bvh.hpp"
#include "../../eval/io/animated_png.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/io/png.hpp"
#include "../../eval/lod/view.hpp"
#include "../../eval/render/render.hpp"
#include "../../hier/base/files.hpp"
#include "../../hier/base/version.hpp"

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tetrakis::cli {
namespace {

struct LodCommandOptions {
    LodInput input;
    std::filesystem::path directory, path, report;
    bool orbit = false, fly = false, wait = false;
    std::uint32_t leaves = 200'000, frames = 120, images = 0;
    double pixels = 1;
    RenderOptions render;
    RunOptions run;
};

/// Visibility and projected sizes for a camera.
class Sight {
  public:
    explicit Sight(const lod::Camera& camera)
        : eye_(camera.eye),
          forward_(camera.direction),
          right_(glm::normalize(glm::cross(forward_, camera.up))),
          up_(glm::cross(right_, forward_)),
          tan_y_(std::tan(camera.vertical_fov / 2)),
          tan_x_(tan_y_ * camera.width / camera.height),
          pixels_(camera.height / (2 * tan_y_)) {}
    bool sees(const Vec3d& p) const {
        const Vec3d off = p - eye_;
        const double depth = glm::dot(off, forward_);
        return depth > 0 && std::abs(glm::dot(off, right_)) <= tan_x_ * depth &&
               std::abs(glm::dot(off, up_)) <= tan_y_ * depth;
    }
    /// Largest projected length, in pixels, of a segment of this length at `p`.
    double pixels(double length, const Vec3d& p) const { return length * pixels_ / glm::length(p - eye_); }

  private:
    Vec3d eye_, forward_, right_, up_;
    double tan_y_, tan_x_, pixels_;
};

/// Largest error, in pixels, at the points of the surface `places` that the camera sees.
double measured_pixels(const TriangleMesh& mesh, std::span<const Vec3d> places, const Sight& sight,
                       const RunContext& context) {
    std::vector<Vec3d> seen;
    for (const Vec3d& place : places)
        if (sight.sees(place)) seen.push_back(place);
    std::vector<ClosestPoint> nearest(seen.size());
    TriangleBvh(mesh, context).closest(seen, nearest, context);
    double largest = 0;
    for (std::size_t i = 0; i < seen.size(); ++i)
        largest = std::max(largest, sight.pixels(nearest[i].distance, seen[i]));
    return largest;
}

/// Positions at which a view shows its vertices, compared from frame to frame.
class ShownVertices {
  public:
    /// Goes on to a new frame. Returns the largest motion of a vertex by LOD alone, in pixels as seen by the new eye.
    double move_to(const lod::View& view, const lod::Update& update, const Vec3d& eye, const Sight& sight) {
        const auto vertices = view.vertices();
        std::vector<Shown> now(vertices.size());
        for (const lod::Triangle& t : view.triangles()) {
            if (t == lod::Triangle{}) continue;
            for (const std::uint32_t v : t) now[v].used = true;
        }
        double farthest = 0;
        for (std::size_t v = 0; v < now.size(); ++v) {
            if (!now[v].used) continue;
            now[v].vertex = vertices[v];
            now[v].at = view.origin() + shown_position(vertices[v], eye - view.origin(), update.morph_scale);
            const bool stayed =
                v < before_.size() && before_[v].used && before_[v].vertex.position == vertices[v].position;
            const auto& edge = vertices[v].on_edge;
            const Vec3d from = stayed ? before_[v].at : view.origin() + Vec3d(edge[0], edge[1], edge[2]);
            if (!before_.empty() && sight.sees(now[v].at))
                farthest = std::max(farthest, sight.pixels(glm::length(now[v].at - from), now[v].at));
        }
        // A vertex that a merge has removed moves to its edge.
        for (std::size_t v = 0; v < before_.size(); ++v) {
            const Shown& old = before_[v];
            const bool stays = v < now.size() && now[v].used && now[v].vertex.position == old.vertex.position;
            if (!old.used || stays || !sight.sees(old.at)) continue;
            const auto& edge = old.vertex.on_edge;
            const Vec3d to = view.origin() + Vec3d(edge[0], edge[1], edge[2]);
            farthest = std::max(farthest, sight.pixels(glm::length(old.at - to), old.at));
        }
        before_ = std::move(now);
        return farthest;
    }
    /// The mesh as shown, with morphing.
    TriangleMesh mesh(const lod::View& view) const {
        TriangleMesh mesh;
        for (const Shown& vertex : before_) mesh.positions.push_back(vertex.at);
        for (const lod::Triangle& t : view.triangles())
            if (t != lod::Triangle{}) mesh.triangles.push_back(t);
        return mesh;
    }

  private:
    struct Shown {
        bool used = false;
        lod::Vertex vertex{};
        Vec3d at{};
    };
    std::vector<Shown> before_;
};

void paste(const Image& from, Image& to, int x, int y) {
    for (int row = 0; row < from.height; ++row)
        std::copy_n(from.rgb.begin() + 3 * std::ptrdiff_t{row} * from.width, 3 * from.width,
                    to.rgb.begin() + 3 * (std::ptrdiff_t{y + row} * to.width + x));
}

/// Renders the mesh. An inset in a corner shows the middle of the picture enlarged, with the mesh's edges.
Image picture(const TriangleMesh& mesh, const CameraPlace& view, RenderOptions render, const RunContext& context) {
    render.camera = Camera{view.eye, view.target, view.up(), view.fov_degrees};
    render.ground = false;
    Image image = tetrakis::render(mesh, render, context);
    render.width = std::min(image.width, std::max(16, image.width * 2 / 5));
    render.height = std::min(image.height, std::max(16, image.height * 2 / 5));
    constexpr double k_middle = 0.2;  // of the picture's sides
    double& fov = render.camera->vertical_fov_degrees;
    fov = glm::degrees(2 * std::atan(k_middle * std::tan(glm::radians(fov) / 2)));
    render.wireframe = true;
    render.shading = Shading::flat;
    render.occlusion_samples = 0;
    paste(tetrakis::render(mesh, render, context), image, image.width - render.width, 0);
    return image;
}

/// Pictures side by side, in rows of at most four that are equally full.
Image contact_sheet(const std::vector<Image>& images) {
    constexpr std::size_t k_most = 4;
    const std::size_t row_count = (images.size() + k_most - 1) / k_most,
                      across = (images.size() + row_count - 1) / row_count;
    const auto columns = static_cast<int>(across), rows = static_cast<int>(row_count);
    Image sheet{columns * images[0].width, rows * images[0].height, {}};
    sheet.rgb.assign(std::size_t{3} * static_cast<std::size_t>(sheet.width) * static_cast<std::size_t>(sheet.height),
                     255);
    for (std::size_t i = 0; i < images.size(); ++i)
        paste(images[i], sheet, static_cast<int>(i % across) * images[0].width,
              static_cast<int>(i / across) * images[0].height);
    return sheet;
}

/// Random points of a tiled terrain, which is opened a second time, so that the view has to request its own tiles.
std::vector<Vec3d> places_of_tiles(const std::filesystem::path& path, const RunContext& context) {
    constexpr std::uint32_t k_parts = 250, k_places = 16;  // each place may be in a tile of its own
    const lod::TiledTerrain terrain(path);
    std::vector<Vec3d> places;
    for (std::uint32_t part = 0; part < k_parts; ++part) {
        context.report("places", double(part) / k_parts);
        std::vector<Vec3d> found;
        for (std::uint64_t revision = 0;; terrain.wait(revision)) {
            revision = terrain.revision();
            found = lod::random_places(terrain, k_places, part + 1);
            // A damaged tile is never loaded.
            if (found.size() == k_places || terrain.statistics().failures > 0) break;
        }
        places.insert(places.end(), found.begin(), found.end());
    }
    return places;
}

ExitCode run_checked(const LodCommandOptions& options) {
    Run process(options.run);
    std::vector<std::string> warnings;
    const LodScene scene = options.input.load(process, warnings);
    const lod::Surface& surface = *scene.surface;
    const std::vector<CameraPlace> cameras =
        options.path.empty() ? circle(scene, options.frames, !options.orbit) : cameras_of(options.path, options.frames);
    constexpr std::uint32_t k_places = 50'000;
    const std::vector<Vec3d> places = scene.tiles == nullptr
                                          ? lod::random_places(surface, k_places)
                                          : places_of_tiles(options.input.heights.path, process.context());
    lod::View view(surface, {.max_leaves = options.leaves});
    view.set_origin(cameras.front().eye);
    if (options.leaves < surface.roots().halfedge_count())
        warnings.push_back(fmt::format("the {} roots are more than the budget of {} triangles",
                                       surface.roots().halfedge_count(), options.leaves));

    std::error_code failure;
    std::filesystem::create_directories(options.directory, failure);
    if (failure) throw Error(ErrorCode::io, fmt::format("cannot be made: {}", failure.message()), options.directory);
    FileSet files;
    std::vector<std::filesystem::path> written;
    const auto file = [&](const std::filesystem::path& path) -> AtomicFile& {
        written.push_back(path);
        return files.add(path);
    };
    std::string csv =
        "frame,splits,merges,leaves,upload_bytes,milliseconds,promised_pixels,measured_pixels,pop_pixels\n";
    ShownVertices shown;
    std::vector<Image> images;
    std::vector<double> milliseconds;
    double worst_error = 0, worst_promise = 0, worst_pop = 0, changes = 0, bytes = 0;
    bool kept_promise = true;
    std::uint32_t waiting_frames = 0;
    bool waits = options.wait;
    for (std::uint32_t frame = 0; frame < cameras.size(); ++frame) {
        process.context().report("frames", static_cast<double>(frame) / static_cast<double>(cameras.size()));
        const CameraPlace& at = cameras[frame];
        const lod::Camera camera = at.lod_camera(options.render.width, options.render.height);
        lod::Update update;
        std::uint32_t splits = 0, merges = 0;
        std::uint64_t upload = 0;
        double took = 0;
        for (;;) {
            const std::uint64_t revision = surface.revision();
            if (waits && update.waiting > 0) process.context().report("tiles", 0);
            const Stopwatch watch;
            update = view.update(camera, {.pixel_error = options.pixels, .leaves = options.leaves});
            took = std::max(took, 1000 * watch.seconds());
            splits += update.splits;
            merges += update.merges;
            for (const auto& range : update.vertices) upload += range.count * sizeof(lod::Vertex);
            for (const auto& range : update.triangles) upload += range.count * sizeof(lod::Triangle);
            if (!waits || update.waiting == 0) break;
            const lod::TileStatistics before = scene.tiles->statistics();
            scene.tiles->wait(revision, std::chrono::seconds(2));
            const lod::TileStatistics after = scene.tiles->statistics();
            // Damaged tiles are never loaded: do not wait for them.
            waits = after.loads > before.loads || after.failures == before.failures;
        }
        if (update.waiting > 0) ++waiting_frames;
        const Sight sight(camera);
        const double error = places.empty() ? 0 : measured_pixels(view.mesh(), places, sight, process.context()),
                     pop = shown.move_to(view, update, at.eye, sight);
        csv += fmt::format("{},{},{},{},{},{:.3f},{:.4g},{},{:.4g}\n", frame, splits, merges, update.leaves, upload,
                           took, update.pixel_error, places.empty() ? "" : fmt::format("{:.4g}", error), pop);
        // The bound does not hold for diamonds that are not loaded yet.
        if (update.waiting == 0) kept_promise = kept_promise && error <= update.pixel_error * (1 + 1e-3);
        worst_error = std::max(worst_error, error);
        worst_promise = std::max(worst_promise, update.pixel_error);
        if (frame > 0) {
            worst_pop = std::max(worst_pop, pop);
            milliseconds.push_back(took);
            changes += splits + merges;
            bytes += static_cast<double>(upload);
        }
        const std::uint64_t drawn = std::uint64_t{frame} * options.images / cameras.size(),
                            next = (std::uint64_t{frame} + 1) * options.images / cameras.size();
        if (next > drawn) {
            images.push_back(picture(shown.mesh(view), at, options.render, process.context()));
            write_png(file(options.directory / fmt::format("frame_{:05}.png", frame)), images.back());
        }
    }
    if (!images.empty()) {
        write_png(file(options.directory / "sheet.png"), contact_sheet(images));
        constexpr int k_frames_per_second = 12;
        write_animated_png(file(options.directory / "flight.png"), images, k_frames_per_second);
    }
    file(options.directory / "frames.csv").write(csv);
    write_mesh(file(options.directory / "last.glb"), view.mesh(), process.context());
    std::sort(milliseconds.begin(), milliseconds.end());
    const double count = std::max(1.0, static_cast<double>(milliseconds.size()));
    const double median = milliseconds.empty() ? 0 : milliseconds[milliseconds.size() / 2];
    const double slowest = milliseconds.empty() ? 0 : milliseconds.back();
    Json tiles;
    if (scene.tiles != nullptr) {
        const lod::TileStatistics statistics = scene.tiles->statistics();
        tiles = {{"loads", statistics.loads},
                 {"failures", statistics.failures},
                 {"cached_bytes", statistics.cached_bytes},
                 {"waiting_frames", waiting_frames}};
        if (statistics.failures > 0)
            warnings.push_back(fmt::format("{} times a tile could not be loaded; the last time: {}",
                                           statistics.failures, statistics.last_error));
    }
    if (!options.report.empty()) {
        file(options.report)
            .write(dump({{"input", options.input.title().string()},
                         {"surface", scene.description},
                         {"frames", cameras.size()},
                         {"budget_leaves", options.leaves},
                         {"budget_pixels", options.pixels},
                         {"leaves", view.leaf_count()},
                         {"changes_a_frame", changes / count},
                         {"upload_bytes_a_frame", bytes / count},
                         {"milliseconds", {{"median", median}, {"largest", slowest}}},
                         {"promised_pixels", worst_promise},
                         {"measured_pixels", places.empty() ? Json() : Json(worst_error)},
                         {"pop_pixels", worst_pop},
                         {"view_bytes", view.memory_bytes()},
                         {"surface_bytes",
                          scene.tiles == nullptr ? scene.surface_bytes : scene.tiles->statistics().cached_bytes},
                         {"tiles", tiles},
                         {"threads", options.run.thread_count()},
                         {"version", std::string(k_version)},
                         {"warnings", warnings}}));
    }
    files.finish();
    files.commit();
    process.end_progress();
    print_warnings(warnings);
    Table table;
    table.row("input", fmt::format("{} ({})", options.input.title().string(), scene.description));
    table.row("frames", fmt::format("{}, of up to {} triangles; the last has {}", cameras.size(),
                                    format_count(options.leaves), format_count(view.leaf_count())));
    table.row("an update",
              fmt::format("{:.3f} ms (median; at most {:.2f}), {:.0f} splits and merges, {}", median, slowest,
                          changes / count, format_bytes(static_cast<std::uint64_t>(bytes / count))));
    table.row("error", places.empty()
                           ? fmt::format("{:.3g} pixels promised (asked: {:.3g})", worst_promise, options.pixels)
                           : fmt::format("{:.3g} pixels seen at most, of {:.3g} promised (asked: {:.3g})", worst_error,
                                         worst_promise, options.pixels));
    if (scene.tiles != nullptr)
        table.row("tiles", fmt::format("{} loaded; {} frames had not all of them",
                                       format_count(scene.tiles->statistics().loads), waiting_frames));
    table.row("pop", fmt::format("{:.3g} pixels in a frame at most", worst_pop));
    std::string names;
    for (const auto& path : written) names += (names.empty() ? "" : ", ") + path.string();
    table.row("written",
              written.size() > 4 ? fmt::format("{} files in {}", written.size(), options.directory.string()) : names);
    table.print();
    return kept_promise && worst_promise <= options.pixels ? ExitCode::done : ExitCode::tolerance_not_reached;
}

ExitCode run(const LodCommandOptions& options) {
    if (options.wait && lower_extension(options.input.heights.path) != ".tiles")
        throw UsageError("--wait is for .tiles: all of other surfaces is there");
    OutputFiles outputs;
    outputs.add(OutputFiles::Kind::report, "--report", options.report);
    outputs.check(options.input.inputs(options.path));
    if (std::filesystem::exists(options.directory) && !std::filesystem::is_directory(options.directory))
        throw UsageError(fmt::format("-o {} is a file; it has to be a directory", options.directory.string()));
    return about(options.input.title(), [&] { return run_checked(options); });
}

}  // namespace

void add_lod_command(CommandLine program) {
    auto options = std::make_shared<LodCommandOptions>();
    options->render.width = 960;
    options->render.height = 540;
    CommandLine command = program.command(
        "lod", "Flies over heights, a planet, a control mesh or a fractal with view-dependent LOD, frame by frame",
        "x runs east, y north, z up, as `tetrakis terrain` has them. Exit code 4: the budget did not reach --pixels.\n"
        "Example:\n  tetrakis lod data/island.png --scale 0.1 --spacing 40 --pixels 0.5 --frames 12 --images 1 -o "
        "island");
    options->input.add(command);
    CommandLine way = command.at_most_one("camera", "At most one of these; default: --fly");
    way.flag("--fly", options->fly, "Once around, above the ground, looking ahead");
    way.flag("--orbit", options->orbit, "Once around from outside, looking at the middle");
    way.option("--path", "CAMERA.json", options->path,
               "A list of {\"eye\": [x, y, z], \"target\": [x, y, z], \"fov_degrees\": a}, on which the frames lie");
    command.option("--budget", "N", options->leaves, "Most triangles (200000)").range(1u, 100'000'000u);
    command.option("--pixels", "E", options->pixels, "Triangles whose error looks larger are split (1)").positive();
    command.flag("--wait", options->wait, "Of .tiles: each frame waits until all of it is loaded");
    command.option("--frames", "N", options->frames, "How many (120)").range(1u, 1'000'000u);
    command
        .option(
            "--images", "N", options->images,
            "Pictures to draw of them (24 if no number is given), a sheet of all, and flight.png, which is animated; "
            "without it none")
        .range(0u, 10'000u)
        .value_or("24");
    add_size_option(command, options->render);
    options->run.add(command);
    command.option("-o,--output", "DIR", options->directory, "Directory for frames.csv, pictures and last.glb")
        .required();
    command.option("--report", "R.json", options->report, "Write figures as JSON");
    command.runs([options] { return run(*options); });
}

}  // namespace tetrakis::cli
