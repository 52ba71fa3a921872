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
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>
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

/// Points of the full-resolution surface near random triangles in sight, which are small near the eye: so each part of
/// the picture has about as many. Borders of roots have none.
/// @param leaves  of the view, as many as the triangles of `shown`
/// @param tiles   the surface, if it is a tiled terrain: its tiles are waited for, unless they are damaged
std::vector<Vec3d> places_near(const std::vector<std::array<Site, 3>>& leaves, const TriangleMesh& shown,
                               const Sight& sight, const lod::Surface& surface, const lod::TiledTerrain* tiles,
                               const RunContext& context) {
    std::vector<std::array<Site, 3>> triangles;
    for (std::size_t i = 0; i < leaves.size(); ++i)
        if (std::ranges::any_of(shown.triangles[i], [&](auto v) { return sight.sees(shown.positions[v]); }))
            triangles.push_back(leaves[i]);
    if (triangles.empty()) triangles = leaves;
    // Each site may be in a tile of its own.
    const std::uint32_t parts = tiles == nullptr ? 1 : 64, count = tiles == nullptr ? 20'000 : 16;
    const int level = (surface.max_depth() - 1) / 2;  // the finest of whose sites all may be vertices
    const std::uint32_t side = 1u << level;
    std::mt19937_64 random;
    std::vector<Vec3d> positions;
    for (std::uint32_t part = 0; part < parts; ++part) {
        std::vector<Site> sites(count);
        for (Site& site : sites) {
            // At most a leg's length, along each axis, from the corner with the right angle.
            site = triangles[random() % triangles.size()][2];
            const std::uint32_t leg = side >> site.level,
                                x = (site.at.x - 1) * leg + static_cast<std::uint32_t>(random() % (2 * leg + 1)),
                                y = (site.at.y - 1) * leg + static_cast<std::uint32_t>(random() % (2 * leg + 1));
            if (x - 1 >= side - 1 || y - 1 >= side - 1) continue;  // where sites may have several addresses
            const int shift = std::countr_zero(x | y);             // to the lowest level that has it
            site = {site.root, {x >> shift, y >> shift}, static_cast<std::uint8_t>(level - shift)};
        }
        std::vector<lod::Place> places(count);
        for (std::uint64_t revision = 0;; tiles->wait(revision, std::chrono::seconds(2))) {
            context.report("places", double(part) / parts);
            revision = surface.revision();
            const lod::SurfaceUse use(surface);  // older tiles may be dropped
            surface.places(sites, places);
            if (tiles == nullptr || tiles->statistics().failures > 0 || std::ranges::all_of(places, &lod::Place::known))
                break;
        }
        for (const lod::Place& place : places)
            if (place.known) positions.push_back(place.position);
    }
    return positions;
}

/// Largest error, in pixels, at the points of the surface `places` that the camera sees; NaN if it sees none.
double measured_pixels(const TriangleMesh& mesh, std::span<const Vec3d> places, const Sight& sight,
                       const RunContext& context) {
    std::vector<Vec3d> seen;
    for (const Vec3d& place : places)
        if (sight.sees(place)) seen.push_back(place);
    std::vector<ClosestPoint> nearest(seen.size());
    TriangleBvh(mesh, context).closest(seen, nearest, context);
    double largest = std::nan("");
    for (std::size_t i = 0; i < seen.size(); ++i)
        largest = std::fmax(largest, sight.pixels(nearest[i].distance, seen[i]));
    return largest;
}

/// Positions at which a view shows its vertices, compared from frame to frame. A vertex is known by its place, because
/// a view numbers them anew when it starts again from the roots. So the view's origin has to stay.
class ShownVertices {
  public:
    /// Goes on to a new frame. Returns the largest motion of a vertex by LOD alone, in pixels as seen by the new eye.
    double move_to(const lod::View& view, const lod::Update& update, const Vec3d& eye, const Sight& sight) {
        const auto vertices = view.vertices();
        std::vector<Shown> now;
        std::vector<bool> is_listed(vertices.size());
        mesh_.positions.resize(vertices.size());
        mesh_.triangles.clear();
        for (const lod::Triangle& t : view.triangles()) {
            if (t == lod::Triangle{}) continue;
            mesh_.triangles.push_back(t);
            for (const std::uint32_t v : t) {
                if (is_listed[v]) continue;
                is_listed[v] = true;
                const auto& edge = vertices[v].on_edge;
                mesh_.positions[v] =
                    view.origin() + shown_position(vertices[v], eye - view.origin(), update.morph_scale);
                now.push_back(
                    {vertices[v].position, mesh_.positions[v], view.origin() + Vec3d(edge[0], edge[1], edge[2])});
            }
        }
        std::ranges::sort(now, {}, &Shown::place);
        double farthest = 0;
        const auto moves = [&](const Vec3d& from, const Vec3d& at) {
            if (!before_.empty() && sight.sees(at))
                farthest = std::max(farthest, sight.pixels(glm::length(at - from), at));
        };
        // Vertices come from their edges, and go there.
        auto old = before_.begin();
        for (const Shown& vertex : now) {
            for (; old != before_.end() && old->place < vertex.place; ++old) moves(old->on_edge, old->at);
            const bool stays = old != before_.end() && old->place == vertex.place;
            moves(stays ? (old++)->at : vertex.on_edge, vertex.at);
        }
        for (; old != before_.end(); ++old) moves(old->on_edge, old->at);
        before_ = std::move(now);
        return farthest;
    }
    /// The mesh as shown, with morphing.
    const TriangleMesh& mesh() const { return mesh_; }

  private:
    struct Shown {
        std::array<float, 3> place;
        Vec3d at, on_edge;
    };
    std::vector<Shown> before_;  // sorted by place
    TriangleMesh mesh_;
};

void paste(const Image& from, Image& to, int x, int y) {
    for (int row = 0; row < from.height; ++row)
        std::copy_n(from.rgb.begin() + 3 * std::ptrdiff_t{row} * from.width, 3 * from.width,
                    to.rgb.begin() + 3 * (std::ptrdiff_t{y + row} * to.width + x));
}

/// Renders the mesh. An inset in a corner shows a part enlarged, with its edges: the middle of the vertices in
/// sight.
Image picture(const TriangleMesh& mesh, const CameraPlace& view, const Sight& sight, RenderOptions render,
              const RunContext& context) {
    render.camera = Camera{view.eye, view.target, view.up(), view.fov_degrees};
    render.ground = false;
    Image image = tetrakis::render(mesh, render, context);
    render.width = std::min(image.width, std::max(16, image.width * 2 / 5));
    render.height = std::min(image.height, std::max(16, image.height * 2 / 5));
    Vec3d middle(0);
    for (const lod::Triangle& t : mesh.triangles)
        if (const Vec3d& at = mesh.positions[t[0]]; sight.sees(at)) middle += glm::normalize(at - view.eye);
    constexpr double k_part = 0.2;  // of the picture's sides
    const double fov = glm::degrees(2 * std::atan(k_part * std::tan(glm::radians(view.fov_degrees) / 2)));
    const CameraPlace inset{view.eye, middle == Vec3d(0) ? view.target : view.eye + middle, fov, view.about_up};
    render.camera = Camera{inset.eye, inset.target, inset.up(), inset.fov_degrees};
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

ExitCode run_checked(const LodCommandOptions& options) {
    Run process(options.run);
    std::vector<std::string> warnings;
    const LodScene scene = options.input.load(process, warnings);
    const lod::Surface& surface = *scene.surface;
    const std::vector<CameraPlace> cameras =
        options.path.empty() ? circle(scene, options.frames, !options.orbit) : cameras_of(options.path, options.frames);
    // Tiles are opened a second time for measurements, so that the view has to request its own, but for those below the
    // eye.
    const auto tiles =
        scene.tiles == nullptr ? nullptr : std::make_unique<lod::TiledTerrain>(options.input.heights.path);
    constexpr std::uint32_t k_places = 20'000;
    const std::vector<Vec3d> everywhere =
        tiles == nullptr ? lod::random_places(surface, k_places) : std::vector<Vec3d>();
    // The rest is for copies of its mesh, and for measuring.
    lod::View view(surface, {.max_leaves = options.leaves, .max_bytes = process.context().max_memory_bytes / 4});
    if (view.max_leaves() < options.leaves)
        warnings.push_back(fmt::format("--max-memory has room for {} triangles", format_count(view.max_leaves())));
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
    double worst_error = std::nan(""), worst_promise = 0, worst_pop = 0, changes = 0, bytes = 0;
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
        const auto update_to = [&](const lod::Camera& to) {
            const Stopwatch watch;
            update = view.update(to, {.pixel_error = options.pixels, .leaves = options.leaves});
            took = std::max(took, 1000 * watch.seconds());
            splits += update.splits;
            merges += update.merges;
            for (const auto& range : update.vertices) upload += range.count * sizeof(lod::Vertex);
            for (const auto& range : update.triangles) upload += range.count * sizeof(lod::Triangle);
        };
        const Sight sight(camera);
        if (scene.is_far(view.origin(), at.eye)) {
            view.set_origin(at.eye);
            if (frame > 0) {  // the last picture again, relative to the new origin
                const CameraPlace& last = cameras[frame - 1];
                update_to(last.lod_camera(options.render.width, options.render.height));
                shown.move_to(view, update, last.eye, sight);
            }
        }
        for (;;) {
            const std::uint64_t revision = surface.revision();
            if (waits && update.waiting > 0) process.context().report("tiles", 0);
            update_to(camera);
            if (!waits || update.waiting == 0) break;
            const lod::TileStatistics before = scene.tiles->statistics();
            scene.tiles->wait(revision, std::chrono::seconds(2));
            const lod::TileStatistics after = scene.tiles->statistics();
            // Damaged tiles are never loaded: do not wait for them.
            waits = after.loads > before.loads || after.failures == before.failures;
        }
        if (update.waiting > 0) ++waiting_frames;
        const double pop = shown.move_to(view, update, at.eye, sight);
        std::vector<Vec3d> places = places_near(view.leaves(), shown.mesh(), sight, tiles == nullptr ? surface : *tiles,
                                                tiles.get(), process.context());
        places.insert(places.end(), everywhere.begin(), everywhere.end());
        const double error = measured_pixels(view.mesh(), places, sight, process.context());
        csv += fmt::format("{},{},{},{},{},{:.3f},{:.4g},{},{:.4g}\n", frame, splits, merges, update.leaves, upload,
                           took, update.pixel_error, std::isnan(error) ? "" : fmt::format("{:.4g}", error), pop);
        // The bound does not hold for diamonds that are not loaded yet.
        if (update.waiting == 0) kept_promise = kept_promise && !(error > update.pixel_error * (1 + 1e-3));
        worst_error = std::fmax(worst_error, error);
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
            images.push_back(picture(shown.mesh(), at, sight, options.render, process.context()));
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
    Json loaded;
    if (scene.tiles != nullptr) {
        const lod::TileStatistics statistics = scene.tiles->statistics();
        loaded = {{"loads", statistics.loads},
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
                         {"measured_pixels", std::isnan(worst_error) ? Json() : Json(worst_error)},
                         {"pop_pixels", worst_pop},
                         {"view_bytes", view.memory_bytes()},
                         {"surface_bytes",
                          scene.tiles == nullptr ? scene.surface_bytes : scene.tiles->statistics().cached_bytes},
                         {"tiles", loaded},
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
    table.row("error", std::isnan(worst_error)
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
