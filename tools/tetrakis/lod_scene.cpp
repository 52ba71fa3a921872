#include "lod_scene.hpp"

#include "console.hpp"
#include "files.hpp"
#include "run_options.hpp"

#include "../../eval/lod_surfaces/planet_surface.hpp"
#include "../../eval/lod_surfaces/procedural_surface.hpp"
#include "../../eval/lod_surfaces/subdivision_surface.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../hier/base/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

namespace tetrakis::cli {

namespace {

/// Whether a point is too far away for the origin of a view's vertices (View::set_origin()).
bool is_too_far(const Vec3d& p) { return !(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= 1e30); }

/// @param grid  the heights' grid, which needs no heights
LodScene terrain_scene(std::unique_ptr<const lod::Surface> surface, const HeightGrid& grid, double lowest,
                       double highest) {
    const double width = (grid.columns - 1) * grid.spacing.x, height = (grid.rows - 1) * grid.spacing.y;
    LodScene scene;
    scene.size = std::min(width, height);
    scene.middle = {grid.origin.x + width / 2, grid.origin.y - height / 2, lowest + 0.3 * (highest - lowest)};
    scene.description = fmt::format("{} x {} samples", grid.columns, grid.rows);
    // Height at the nearest point of the grid, by the finest triangles that are loaded; `highest` without any.
    scene.low = [terrain = surface.get(), west = grid.origin.x, east = grid.origin.x + width, north = grid.origin.y,
                 south = grid.origin.y - height, top = highest + 1](const Vec3d& p) {
        const Vec3d above(std::clamp(p.x, west, east), std::clamp(p.y, south, north), top);
        return top - terrain->hit(above, {0, 0, -1}).value_or(lod::SurfaceHit{1, {}}).t;
    };
    scene.surface = std::move(surface);
    return scene;
}

LodScene terrain_scene(HeightGrid grid, const Run& process) {
    const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
    const double lowest{*low}, highest{*high};
    auto surface = std::make_unique<lod::TerrainSurface>(std::move(grid), process.context());
    const lod::TerrainSurface& terrain = *surface;
    LodScene scene = terrain_scene(std::move(surface), terrain.grid(), lowest, highest);
    scene.surface_bytes = terrain.memory_bytes();
    return scene;
}

LodScene tiles_scene(const std::filesystem::path& path, std::uint64_t cache_bytes) {
    auto surface = std::make_unique<lod::TiledTerrain>(path, lod::TiledTerrainOptions{.cache_bytes = cache_bytes});
    const lod::TiledTerrain& tiles = *surface;
    const auto [lowest, highest] = tiles.lowest_highest();
    LodScene scene = terrain_scene(std::move(surface), tiles.frame(), lowest, highest);
    scene.description += ", tiles";
    scene.tiles = &tiles;
    return scene;
}

/// A fractal scene. Its heights are computed on demand.
/// @param planet_radius  0: a square
/// @param finest         side of the smallest triangles; 0: a millionth of the scene's size
LodScene fractal_scene(std::uint64_t seed, double planet_radius, double finest) {
    constexpr double k_side = 1e5;  // of the square
    // Of the first layer, relative to the size. 200000 triangles then reach one pixel in a flight at 960 x 540.
    constexpr double k_wavelength = 0.5, k_amplitude = 1 / 150.0, k_ball_amplitude = 1 / 400.0;
    LodScene scene;
    scene.is_round = planet_radius > 0;
    scene.size = scene.is_round ? 2 * planet_radius : k_side;
    if (finest == 0) finest = 1e-6 * scene.size;
    // The shortest waves are longer than two of the smallest triangles.
    const double octaves = std::floor(std::log2(k_wavelength * scene.size / (2 * finest)));
    try {
        const lod::ProceduralHeights heights =
            lod::fractal_heights((scene.is_round ? k_ball_amplitude : k_amplitude) * scene.size,
                                 k_wavelength * scene.size, static_cast<int>(std::clamp(octaves, 1.0, 48.0)), seed);
        scene.low = [heights, planet_radius](const Vec3d& p) {
            return planet_radius > 0 ? planet_radius + heights.height(planet_radius * glm::normalize(p))
                                     : heights.height({p.x, p.y, 0});
        };
        scene.surface = std::make_unique<lod::ProceduralSurface>(
            scene.is_round ? lod::ProceduralSurface::ball(planet_radius, finest, heights)
                           : lod::ProceduralSurface::plane(k_side, finest, heights));
    } catch (const Error& error) {
        throw UsageError(fmt::format("--spacing: {}", error.what()));
    }
    scene.description = fmt::format("nothing stored, triangles down to {:.3g}", finest);
    return scene;
}

}  // namespace

std::filesystem::path LodInput::title() const {
    return fractal ? std::filesystem::path(fmt::format("fractal {}", *fractal)) : heights.path;
}

std::vector<std::filesystem::path> LodInput::inputs(const std::filesystem::path& path) const {
    std::vector<std::filesystem::path> files = faces;
    files.insert(files.end(), {heights.path, path});
    return files;
}

void LodInput::add(CommandLine command) {
    heights.add(command, "Heights, as `tetrakis terrain` reads them, .tiles, or a control mesh (.obj)").required(false);
    command.option("FACES", "", faces, "With --planet: IN is a cube's face +x, and these are -x, +y, -y, +z, -z");
    command.option("--fractal", "SEED", fractal,
                   "In place of IN: fractal heights, of a square of 100000 or, with --planet, a ball, down to "
                   "triangles of --spacing");
    command
        .option("--planet", "R", planet_radius,
                "Heights are over longitudes and latitudes, or a cube's faces, of a planet of this radius")
        .number("a radius from 1e-37 to 1e37", [](double radius) { return radius >= 1e-37 && radius <= 1e37; });
    command.option("--scheme", "NAME", scheme,
                   "Of a control mesh: loop, one on quads, doo-sabin or midedge (catmull-clark)");
    command.option("--level", "N", level, "A planet's or control mesh's finest triangles: 2^(N + 1) to an edge")
        .range(1, lod::SampledSurface::k_max_level);
    add_read_options(command, read_mesh);
    add_bytes_option(command, "--cache", cache_bytes, "Most memory for .tiles (512M), beside 512M to measure errors");
}

LodScene LodInput::load(const Run& process, std::vector<std::string>& warnings) const {
    const bool mesh = lower_extension(heights.path) == ".obj",
               for_others = level != 0 || !scheme.empty() || heights.read.scale != 1 || heights.read.offset != 0;
    if (fractal) {
        if (!heights.path.empty() || for_others)
            throw UsageError(
                "--fractal takes --planet and --spacing, but no IN, --level, --scheme, --scale or --offset");
        return fractal_scene(*fractal, planet_radius, heights.spacing);
    }
    if (heights.path.empty()) throw UsageError("IN is required: heights, .tiles, a control mesh, or --fractal SEED");
    if (!faces.empty() && (planet_radius == 0 || faces.size() != 5))
        throw UsageError(
            fmt::format("{} files; one is read, or with --planet the six faces of a cube", 1 + faces.size()));
    if (lower_extension(heights.path) == ".tiles") {
        if (planet_radius > 0 || for_others || heights.spacing > 0)
            throw UsageError(
                "--planet, --level, --scheme, --spacing, --scale and --offset do not change tiles; the last three "
                "are for `tetrakis tiles`");
        return reading(heights.path, [&] { return tiles_scene(heights.path, cache_bytes); });
    }
    if (cache_bytes != LodInput().cache_bytes) throw UsageError("--cache is for .tiles");
    if (!mesh && (read_mesh.weld || read_mesh.repair))
        throw UsageError("--weld and --repair take a control mesh (.obj)");
    if (mesh && (heights.spacing > 0 || heights.read.scale != 1 || heights.read.offset != 0 || heights.read.no_data))
        throw UsageError("--spacing, --scale, --offset and --no-data take heights, not a control mesh");
    if (mesh && planet_radius > 0) throw UsageError("--planet takes heights, not a control mesh");
    if (!mesh && !scheme.empty()) throw UsageError("--scheme takes a control mesh (.obj)");
    if (!mesh && planet_radius == 0) {
        if (level != 0) throw UsageError("--level is about planets and control meshes");
        return terrain_scene(heights.load(process, warnings), process);
    }
    LodScene scene;
    scene.is_round = planet_radius > 0;
    if (scene.is_round) {
        const lod::PlanetOptions options{planet_radius, level, process.context()};
        std::array<HeightGrid, 6> grids{heights.load(process, warnings)};
        scene.description = fmt::format("{} x {} samples {} a planet", grids[0].columns, grids[0].rows,
                                        faces.empty() ? "around" : "on each of six faces of");
        for (std::size_t i = 0; i < faces.size(); ++i) {
            HeightInput face = heights;
            face.path = faces[i];
            grids[i + 1] = face.load(process, warnings);
        }
        auto surface = faces.empty() ? std::make_unique<lod::PlanetSurface>(std::move(grids[0]), options)
                                     : std::make_unique<lod::PlanetSurface>(std::move(grids), options);
        scene.surface_bytes = surface->memory_bytes();
        scene.size = 2 * planet_radius;
        scene.low = [planet = surface.get()](const Vec3d& p) { return planet->radius() + planet->height(p); };
        scene.surface = std::move(surface);
        return scene;
    }
    const SchemeInfo& chosen = chosen_scheme(scheme.empty() ? std::string(name(SchemeKind::catmull_clark)) : scheme);
    const LoadedModel model = load_model(heights.path, read_mesh, process.context(), &chosen);
    const Box3d box = model.mesh.bounding_box();
    scene.middle = 0.5 * (box.lower + box.upper);
    scene.size = box.diagonal();
    scene.up = {0, 1, 0};
    scene.description = fmt::format("{} faces, {}", format_count(model.mesh.face_count()), chosen.title);
    lod::SubdivisionSurfaceOptions options;
    if (level != 0) options.level = level;
    options.context = process.context();
    std::unique_ptr<lod::SubdivisionSurface> surface;
    try {
        surface = std::make_unique<lod::SubdivisionSurface>(model.mesh, chosen, options);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::unsupported) throw;
        throw UsageError(fmt::format("--scheme: {}", error.what()));
    }
    scene.surface_bytes = surface->memory_bytes();
    scene.surface = std::move(surface);
    return scene;
}

lod::Camera CameraPlace::lod_camera(int width, int height) const {
    return {.eye = eye,
            .direction = forward(),
            .up = up(),
            .vertical_fov = fov_degrees * M_PI / 180,
            .width = static_cast<std::uint32_t>(width),
            .height = static_cast<std::uint32_t>(height)};
}

std::vector<CameraPlace> cameras_of(const std::filesystem::path& path, std::uint32_t frames) {
    std::ifstream file(path);
    if (!file) throw InputError(fmt::format("{}: cannot be read", path.string()));
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    std::vector<CameraPlace> given;
    nlohmann::json list;
    try {
        list = nlohmann::json::parse(text);
        if (!list.is_array()) throw InputError(fmt::format("{}: a camera path is a list", path.string()));
        for (const nlohmann::json& entry : list) {
            const auto vec = [&](const char* key) {
                const auto v = entry.at(key).get<std::array<double, 3>>();
                return Vec3d(v[0], v[1], v[2]);
            };
            given.push_back({vec("eye"), vec("target"), entry.value("fov_degrees", 60.0)});
        }
    } catch (const nlohmann::json::exception& error) {
        const std::string reason = error.what();  // "[json.exception.type_error.304] cannot ..."
        throw InputError(
            fmt::format("{}: {}{}; a camera path is a list of {{\"eye\": [x, y, z], \"target\": "
                        "[x, y, z], \"fov_degrees\": a}}",
                        path.string(), list.is_array() ? fmt::format("camera {}: ", given.size()) : "",
                        reason.substr(reason.find("] ") + 2)));
    }
    for (std::size_t i = 0; i < given.size(); ++i) {
        const CameraPlace& camera = given[i];
        const char* fault = is_too_far(camera.eye) || is_too_far(camera.target)
                                ? "its eye or target has a coordinate beyond 1e30; move it nearer"
                            : !(glm::length(camera.target - camera.eye) > 0)
                                ? "its target is at its eye; move one of them"
                            : !(camera.fov_degrees > 0 && camera.fov_degrees < 180)
                                ? "its fov_degrees are not between 0 and 180; without them it has 60"
                                : nullptr;
        if (fault != nullptr) throw InputError(fmt::format("{}: camera {}: {}", path.string(), i, fault));
    }
    if (given.empty()) throw InputError(fmt::format("{}: a camera path without cameras", path.string()));
    std::vector<CameraPlace> cameras;
    for (std::uint32_t i = 0; i < frames; ++i) {
        const double at = frames == 1 ? 0 : static_cast<double>(i) * (given.size() - 1.0) / (frames - 1.0);
        const auto k = static_cast<std::size_t>(at);
        const CameraPlace &a = given[k], &b = given[std::min(k + 1, given.size() - 1)];
        const double t = at - std::floor(at);
        cameras.push_back(
            {glm::mix(a.eye, b.eye, t), glm::mix(a.target, b.target, t), glm::mix(a.fov_degrees, b.fov_degrees, t)});
    }
    for (std::size_t i = 0; i < cameras.size(); ++i)
        if (!(glm::length(cameras[i].target - cameras[i].eye) > 0))
            throw InputError(fmt::format(
                "{}: in frame {} the camera's target is at its eye; add a camera between those before and after it",
                path.string(), i));
    return cameras;
}

std::vector<CameraPlace> circle(const LodScene& scene, std::uint32_t frames, bool fly) {
    const double size = scene.size;
    std::vector<CameraPlace> cameras;
    double above = 0;
    for (std::uint32_t i = 0; i < frames; ++i) {
        const double turn = 2 * M_PI * i / frames;
        const Vec3d z = scene.up, x(1, 0, 0), y = glm::cross(z, x);
        const Vec3d out = std::cos(turn) * x + std::sin(turn) * y, ahead = glm::cross(z, out);
        CameraPlace camera;
        camera.about_up = z;
        if (!fly || !scene.low) {
            // 1.2 diameters from the axis; a flight around a mesh is closer.
            camera.eye = scene.middle + (fly ? 0.8 : 1.2) * size * out +
                         (scene.is_round ? 0.2
                          : fly          ? 0.3
                                         : 0.7) *
                             size * z;
            camera.target = scene.middle;
        } else if (scene.is_round) {
            // Along the equator, above all ground passed so far.
            const double ground = std::max(scene.low(out), scene.low(out + 0.1 * ahead));
            above = std::max(above, ground + 0.02 * size);
            camera.eye = above * out;
            camera.target = camera.eye + size * (ahead - 0.35 * out + 0.2 * z);
            camera.about_up = out;
        } else {
            camera.eye = scene.middle + 0.42 * size * out;
            // The height follows the ground smoothly.
            const double ground = scene.low(camera.eye),
                         wanted = std::max(ground, scene.low(camera.eye + 0.1 * size * ahead)) + 0.12 * size;
            above = i == 0 ? wanted : above + 0.2 * (wanted - above);
            camera.eye.z = std::max(above, ground + 0.03 * size);
            camera.target = camera.eye + size * (ahead - 0.8 * out) - 0.2 * size * z;
        }
        if (is_too_far(camera.eye))
            throw Error(ErrorCode::invalid_input,
                        "it reaches beyond 1e30; make it smaller by --scale, --spacing or --planet");
        cameras.push_back(camera);
    }
    return cameras;
}

}  // namespace tetrakis::cli
