#include "tetrakis_c.h"

#include "../../eval/distance/triangle_bvh.hpp"
#include "../../eval/io/gpu_mesh.hpp"
#include "../../eval/io/mesh_writer.hpp"
#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/planet_surface.hpp"
#include "../../eval/lod_surfaces/procedural_surface.hpp"
#include "../../eval/lod_surfaces/subdivision_surface.hpp"
#include "../../eval/lod_terrain/terrain_surface.hpp"
#include "../../eval/lod_terrain/terrain_tiles.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../eval/terrain/height_grid.hpp"
#include "../../eval/tessellate/tessellate.hpp"
#include "../../hier/base/error.hpp"
#include "../../hier/base/version.hpp"
#include "../../hier/obj/obj_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

using namespace tetrakis;

struct tetrakis_control_mesh {
    ControlMesh mesh;
};
struct tetrakis_mesh {
    GpuMesh mesh;
    bool reached_tolerance;
};
struct tetrakis_surface {
    std::unique_ptr<const lod::Surface> surface;
    /// Null if the surface is of another kind, or null itself.
    template <class Kind>
    static const Kind* as(const tetrakis_surface* surface) {
        return surface == nullptr ? nullptr : dynamic_cast<const Kind*>(surface->surface.get());
    }
};
struct tetrakis_snapshot {
    TriangleMesh mesh;
    TriangleBvh bvh;
    explicit tetrakis_snapshot(TriangleMesh taken) : mesh(std::move(taken)), bvh(mesh) {}
};
struct tetrakis_view {
    lod::View view;
};

static_assert(static_cast<int>(ErrorCode::invalid_input) == TETRAKIS_INVALID_INPUT &&
              static_cast<int>(ErrorCode::io) == TETRAKIS_IO &&
              static_cast<int>(ErrorCode::unsupported) == TETRAKIS_UNSUPPORTED &&
              static_cast<int>(ErrorCode::memory_limit) == TETRAKIS_MEMORY_LIMIT &&
              static_cast<int>(ErrorCode::cancelled) == TETRAKIS_FAILURE);  // nothing here is ever cancelled
static_assert(sizeof(tetrakis_vertex) == sizeof(lod::Vertex) && sizeof(tetrakis_range) == sizeof(lod::Update::Range));

namespace {

thread_local std::string g_last_error;

tetrakis_status failed(tetrakis_status status, const char* text) {
    try {
        g_last_error = text;
    } catch (...) {
        g_last_error.clear();
    }
    return status;
}

/// Runs `work` and converts exceptions to a status.
template <class Work>
tetrakis_status guarded(const Work& work) {
    try {
        work();
        return TETRAKIS_OK;
    } catch (const Error& error) {
        return failed(static_cast<tetrakis_status>(error.code()), error.what());
    } catch (const std::bad_alloc&) {
        return failed(TETRAKIS_MEMORY_LIMIT, "out of memory");
    } catch (const std::exception& error) {
        return failed(TETRAKIS_FAILURE, error.what());
    } catch (...) {
        return failed(TETRAKIS_FAILURE, "an unknown fault");
    }
}

/// For functions without a status: 1 if `look` returns true, 0 if it returns false or throws.
template <class Look>
int looked(const Look& look) {
    int found = 0;
    guarded([&] { found = look() ? 1 : 0; });
    return found;
}

void require(const void* pointer, const char* name) {
    if (pointer == nullptr) throw Error(ErrorCode::invalid_input, std::string(name) + " is NULL");
}

/// Copies a caller's struct, which may have fewer or more fields. Missing fields are as in `defaults`.
template <class Struct>
Struct taken(const Struct* given, const Struct& defaults, const char* name) {
    if (given == nullptr) return defaults;
    if (given->size < sizeof(std::size_t))
        throw Error(ErrorCode::invalid_input, std::string(name) + " does not say its size");
    Struct known = defaults;
    std::memcpy(&known, given, std::min(given->size, sizeof(Struct)));
    known.size = sizeof(Struct);
    return known;
}
template <class Struct>
void require_size(const Struct* receiver, const char* name) {
    require(receiver, name);
    if (receiver->size < sizeof(std::size_t))
        throw Error(ErrorCode::invalid_input, std::string(name) + " does not say its size");
}
/// Copies to a caller's struct as many fields as it has.
template <class Struct>
void give(Struct* receiver, const Struct& result, const char* name) {
    require_size(receiver, name);
    const std::size_t size = receiver->size;
    std::memcpy(receiver, &result, std::min(size, sizeof(Struct)));
    receiver->size = size;
}

Vec3d vec(const double* v) { return {v[0], v[1], v[2]}; }

HeightGrid grid_of(const float* heights, std::uint32_t columns, std::uint32_t rows) {
    require(heights, "heights");
    return {.columns = columns,
            .rows = rows,
            .heights = std::vector<float>(heights, heights + std::size_t{columns} * rows)};
}

tetrakis_height_options known_options(const tetrakis_height_options* given) {
    const tetrakis_height_options known = taken(given, TETRAKIS_HEIGHT_OPTIONS, "options");
    static_assert(static_cast<int>(HeightFormat::gdal) == TETRAKIS_HEIGHTS_GDAL);
    if (known.format < 0 || known.format > TETRAKIS_HEIGHTS_GDAL)
        throw Error(ErrorCode::invalid_input,
                    fmt::format("format is {}; it is a tetrakis_height_format", known.format));
    if (known.gaps < 0 || known.gaps > TETRAKIS_GAPS_LEVEL)
        throw Error(ErrorCode::invalid_input, fmt::format("gaps is {}; it is a tetrakis_gaps", known.gaps));
    if (known.gaps == TETRAKIS_GAPS_LEVEL && !std::isfinite(known.gap_height))
        throw Error(ErrorCode::invalid_input, "gap_height is no number");
    return known;
}
HeightReadOptions read_options(const tetrakis_height_options& known) {
    HeightReadOptions options;
    options.format = static_cast<HeightFormat>(known.format);
    options.columns = known.columns;
    options.rows = known.rows;
    options.big_endian = known.big_endian != 0;
    options.scale = known.scale;
    options.offset = known.offset;
    if (known.has_no_data != 0) options.no_data = known.no_data;
    if (known.spacing[0] != 0 || known.spacing[1] != 0) options.spacing = Vec2d(known.spacing[0], known.spacing[1]);
    return options;
}
HeightGrid load_heights(const char* path, const tetrakis_height_options& known) {
    HeightGrid grid = load_height_grid(path, read_options(known));
    if (known.gaps == TETRAKIS_GAPS_FILLED) fill_missing_heights(grid);
    for (std::size_t i = 0; i < grid.heights.size(); ++i) {
        if (!std::isnan(grid.heights[i])) continue;
        if (known.gaps != TETRAKIS_GAPS_LEVEL)
            throw Error(ErrorCode::invalid_input,
                        fmt::format("the height at column {}, row {} is missing; with TETRAKIS_GAPS_FILLED or "
                                    "TETRAKIS_GAPS_LEVEL it gets one",
                                    i % grid.columns, i / grid.columns),
                        path);
        grid.heights[i] = known.gap_height;
    }
    return grid;
}

lod::ProceduralHeights heights_of(const tetrakis_procedural_heights* given) {
    require(given, "heights");
    const tetrakis_procedural_heights known = taken(given, TETRAKIS_PROCEDURAL_HEIGHTS, "heights");
    if (known.height == nullptr || known.deviation == nullptr)
        throw Error(ErrorCode::invalid_input, "the heights' function height or deviation is NULL");
    return {.height = [known](const Vec3d& place) { return known.height(known.user, &place.x); },
            .deviation = [known](double radius) { return known.deviation(known.user, radius); },
            .slope = known.slope,
            .low = known.low,
            .high = known.high};
}
double fractal_height(void* user, const double place[3]) {
    return static_cast<const lod::ProceduralHeights*>(user)->height(vec(place));
}
double fractal_deviation(void* user, double radius) {
    return static_cast<const lod::ProceduralHeights*>(user)->deviation(radius);
}

/// Creates a handle of a new surface.
/// @param make  returns the surface
template <class Make>
tetrakis_status make_surface(tetrakis_surface** to, const Make& make) {
    return guarded([&] {
        require(to, "surface");
        using Kind = decltype(make());
        *to = new tetrakis_surface{std::unique_ptr<const lod::Surface>(new Kind(make()))};
    });
}

/// Writes three numbers, unless the caller passed NULL.
void give(const Vec3d& from, double* to) {
    if (to != nullptr) std::copy_n(&from.x, 3, to);
}

}  // namespace

const char* tetrakis_version(void) {
    static const std::string version(k_version);
    return version.c_str();
}
const char* tetrakis_last_error(void) { return g_last_error.c_str(); }

tetrakis_status tetrakis_load_control_mesh(const char* path, tetrakis_control_mesh** mesh) {
    return guarded([&] {
        require(path, "path");
        require(mesh, "mesh");
        *mesh = new tetrakis_control_mesh{load_control_mesh(path)};
    });
}

tetrakis_status tetrakis_make_control_mesh(const double* positions, uint32_t vertex_count, const uint32_t* face_sizes,
                                           uint32_t face_count, const uint32_t* face_vertices,
                                           tetrakis_control_mesh** mesh) {
    return guarded([&] {
        require(positions, "positions");
        require(face_sizes, "face_sizes");
        require(face_vertices, "face_vertices");
        require(mesh, "mesh");
        ControlMeshData data;
        for (std::size_t v = 0; v < vertex_count; ++v)
            data.positions.emplace_back(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
        data.face_offsets = {0};
        for (std::uint32_t f = 0; f < face_count; ++f)
            data.face_offsets.push_back(data.face_offsets.back() + face_sizes[f]);
        data.face_vertices.assign(face_vertices, face_vertices + data.face_offsets.back());
        *mesh = new tetrakis_control_mesh{ControlMesh::build(std::move(data))};
    });
}
void tetrakis_free_control_mesh(tetrakis_control_mesh* mesh) { delete mesh; }

tetrakis_status tetrakis_tessellate(const tetrakis_control_mesh* control, const tetrakis_tessellate_options* given,
                                    tetrakis_mesh** mesh) {
    return guarded([&] {
        require(control, "control");
        require(mesh, "mesh");
        const tetrakis_tessellate_options known = taken(given, TETRAKIS_TESSELLATE_OPTIONS, "options");
        require(known.scheme, "scheme");
        TessellateOptions options;
        options.scheme = SchemeChoice(known.scheme);
        if (known.tolerance != 0) options.tolerance = known.tolerance;
        options.tolerance_is_absolute = known.absolute != 0;
        if (known.certified != 0) options.estimator = EstimatorKind::certified;
        options.max_triangles = known.max_triangles;
        RunContext context;
        context.threads = known.threads;
        const Tessellation result = tessellate(control->mesh, options, context);
        const Box3d box = bounding_box(result.mesh.positions);
        *mesh = new tetrakis_mesh{gpu_mesh(result.mesh, (box.lower + box.upper) / 2.0), result.tolerance_reached};
    });
}

tetrakis_status tetrakis_get_mesh_arrays(const tetrakis_mesh* mesh, tetrakis_mesh_arrays* arrays) {
    return guarded([&] {
        require(mesh, "mesh");
        const GpuMesh& m = mesh->mesh;
        tetrakis_mesh_arrays result = TETRAKIS_MESH_ARRAYS;
        result.vertex_count = static_cast<std::uint32_t>(m.positions.size());
        result.triangle_count = static_cast<std::uint32_t>(m.indices.size() / 3);
        result.positions = &m.positions.data()->x;
        result.normals = &m.normals.data()->x;
        result.uvs = m.uvs.empty() ? nullptr : &m.uvs.data()->x;
        result.indices = m.indices.data();
        give(m.origin, result.origin);
        give(arrays, result, "arrays");
    });
}
int tetrakis_mesh_reached_tolerance(const tetrakis_mesh* mesh) { return mesh != nullptr && mesh->reached_tolerance; }
void tetrakis_free_mesh(tetrakis_mesh* mesh) { delete mesh; }

tetrakis_status tetrakis_load_terrain(const char* path, const tetrakis_height_options* options,
                                      tetrakis_surface** surface) {
    return make_surface(surface, [&] {
        require(path, "path");
        return lod::TerrainSurface(load_heights(path, known_options(options)));
    });
}
tetrakis_status tetrakis_make_terrain(const float* heights, uint32_t columns, uint32_t rows, double spacing,
                                      tetrakis_surface** surface) {
    return make_surface(surface, [&] {
        HeightGrid grid = grid_of(heights, columns, rows);
        grid.spacing = Vec2d(spacing);
        return lod::TerrainSurface(std::move(grid));
    });
}
tetrakis_status tetrakis_write_tiles(const char* heights_path, const tetrakis_height_options* options,
                                     const char* tiles_path) {
    return guarded([&] {
        require(heights_path, "heights_path");
        require(tiles_path, "tiles_path");
        if (std::error_code none; std::filesystem::equivalent(heights_path, tiles_path, none))
            throw Error(ErrorCode::invalid_input, "the tiles have the name of the heights; choose another", tiles_path);
        const tetrakis_height_options known = known_options(options);
        if (known.gaps == TETRAKIS_GAPS_FILLED) {
            const HeightGrid grid = load_heights(heights_path, known);
            return lod::write_tiles(*make_height_source(grid), tiles_path);
        }
        lod::TileOptions tiles;
        if (known.gaps == TETRAKIS_GAPS_LEVEL) tiles.missing_height = known.gap_height;
        lod::write_tiles(*open_height_source(heights_path, read_options(known)), tiles_path, tiles);
    });
}
tetrakis_status tetrakis_open_tiles(const char* tiles_path, uint64_t cache_bytes, tetrakis_surface** surface) {
    return make_surface(surface, [&] {
        require(tiles_path, "tiles_path");
        return lod::TiledTerrain(tiles_path, {.cache_bytes = cache_bytes});
    });
}
tetrakis_status tetrakis_make_planet(const float* heights, uint32_t columns, uint32_t rows, double radius, int level,
                                     tetrakis_surface** surface) {
    return make_surface(surface, [&] {
        return lod::PlanetSurface(grid_of(heights, columns, rows), {radius, level, {}});
    });
}
tetrakis_status tetrakis_make_cube_planet(const float* const faces[6], uint32_t side, double radius, int level,
                                          tetrakis_surface** surface) {
    return make_surface(surface, [&] {
        require(faces, "faces");
        std::array<HeightGrid, 6> grids;
        for (std::size_t i = 0; i < grids.size(); ++i) grids[i] = grid_of(faces[i], side, side);
        return lod::PlanetSurface(std::move(grids), {radius, level, {}});
    });
}
tetrakis_status tetrakis_make_fractal_heights(double amplitude, double wavelength, int octaves, uint64_t seed,
                                              tetrakis_procedural_heights* heights) {
    return guarded([&] {
        auto fractal =
            std::make_unique<lod::ProceduralHeights>(lod::fractal_heights(amplitude, wavelength, octaves, seed));
        const tetrakis_procedural_heights result{sizeof result,  fractal_height, fractal_deviation, fractal.get(),
                                                 fractal->slope, fractal->low,   fractal->high};
        give(heights, result, "heights");
        fractal.release();
    });
}
void tetrakis_free_fractal_heights(tetrakis_procedural_heights* heights) {
    if (heights == nullptr || heights->height != fractal_height) return;
    delete static_cast<lod::ProceduralHeights*>(heights->user);
    heights->height = nullptr;
    heights->user = nullptr;
}
tetrakis_status tetrakis_make_procedural_plane(double side, double finest, const tetrakis_procedural_heights* heights,
                                               tetrakis_surface** surface) {
    return make_surface(surface, [&] { return lod::ProceduralSurface::plane(side, finest, heights_of(heights)); });
}
tetrakis_status tetrakis_make_procedural_ball(double radius, double finest, const tetrakis_procedural_heights* heights,
                                              tetrakis_surface** surface) {
    return make_surface(surface, [&] { return lod::ProceduralSurface::ball(radius, finest, heights_of(heights)); });
}
tetrakis_status tetrakis_make_subdivision_surface(const tetrakis_control_mesh* control, const char* scheme, int level,
                                                  tetrakis_surface** surface) {
    return make_surface(surface, [&] {
        require(control, "control");
        require(scheme, "scheme");
        return lod::SubdivisionSurface(control->mesh, scheme, {.level = level});
    });
}
void tetrakis_free_surface(tetrakis_surface* surface) { delete surface; }

int tetrakis_surface_at(const tetrakis_surface* surface, double x, double y, double* height, double normal[3]) {
    return looked([&] {
        const auto* terrain = tetrakis_surface::as<lod::Terrain>(surface);
        const auto ground = terrain == nullptr ? std::nullopt : terrain->at({x, y});
        if (!ground) return false;
        if (height != nullptr) *height = ground->height;
        give(ground->normal, normal);
        return true;
    });
}
int tetrakis_planet_at(const tetrakis_surface* surface, const double direction[3], double* height, double normal[3]) {
    return looked([&] {
        const auto* planet = tetrakis_surface::as<lod::PlanetSurface>(surface);
        if (planet == nullptr || direction == nullptr) return false;
        const Vec3d out = unit_or_zero(vec(direction));
        if (!(glm::length(out) > 0)) return false;
        if (height != nullptr) *height = planet->height(out);
        if (normal != nullptr) give(planet->normal(out), normal);
        return true;
    });
}
uint64_t tetrakis_surface_revision(const tetrakis_surface* surface) {
    return surface == nullptr ? 0 : surface->surface->revision();
}
tetrakis_status tetrakis_get_tile_statistics(const tetrakis_surface* surface, tetrakis_tile_statistics* statistics) {
    return guarded([&] {
        require(surface, "surface");
        const auto* tiles = tetrakis_surface::as<lod::TiledTerrain>(surface);
        if (tiles == nullptr)
            throw Error(ErrorCode::invalid_input, "the surface has no tiles; those of tetrakis_open_tiles() have");
        const lod::TileStatistics now = tiles->statistics();
        thread_local std::string last_error;
        last_error = now.last_error;
        give(statistics,
             tetrakis_tile_statistics{sizeof(tetrakis_tile_statistics), now.loads, now.failures, now.wanted,
                                      now.cached_bytes, last_error.c_str()},
             "statistics");
    });
}
int tetrakis_surface_hit(const tetrakis_surface* surface, const double origin[3], const double direction[3],
                         double farthest, double* t, double normal[3]) {
    return looked([&] {
        if (surface == nullptr || origin == nullptr || direction == nullptr) return false;
        const auto hit = surface->surface->hit(vec(origin), vec(direction), farthest);
        if (!hit) return false;
        if (t != nullptr) *t = hit->t;
        give(hit->normal, normal);
        return true;
    });
}

tetrakis_status tetrakis_make_view(const tetrakis_surface* surface, const tetrakis_view_options* options,
                                   tetrakis_view** view) {
    return guarded([&] {
        require(surface, "surface");
        require(view, "view");
        const tetrakis_view_options known = taken(options, TETRAKIS_VIEW_OPTIONS, "options");
        *view = new tetrakis_view{lod::View(*surface->surface, {.max_leaves = known.max_leaves,
                                                                .max_bytes = known.max_bytes,
                                                                .max_ranges = known.max_ranges,
                                                                .outside_weight = known.outside_weight,
                                                                .hysteresis = known.hysteresis})};
    });
}
void tetrakis_free_view(tetrakis_view* view) { delete view; }
tetrakis_status tetrakis_set_view_regions(tetrakis_view* view, const tetrakis_region* regions, uint32_t count) {
    return guarded([&] {
        require(view, "view");
        if (count > 0) require(regions, "regions");
        std::vector<lod::Region> list;
        for (std::uint32_t i = 0; i < count; ++i)
            list.push_back({vec(regions[i].center), regions[i].radius, regions[i].boost});
        view->view.set_regions(std::move(list));
    });
}

tetrakis_status tetrakis_update_view(tetrakis_view* view, const tetrakis_camera* camera, const tetrakis_budget* budget,
                                     tetrakis_update* update) {
    return guarded([&] {
        require(view, "view");
        require(camera, "camera");
        require_size(update, "update");
        const tetrakis_camera eye = taken(camera, TETRAKIS_CAMERA, "camera");
        const tetrakis_budget known = taken(budget, TETRAKIS_BUDGET, "budget");
        const lod::Update done = view->view.update(
            {.eye = vec(eye.eye),
             .direction = vec(eye.direction),
             .up = vec(eye.up),
             .vertical_fov = eye.vertical_fov,
             .width = eye.width,
             .height = eye.height},
            {.pixel_error = known.pixel_error, .leaves = known.leaves, .milliseconds = known.milliseconds});
        tetrakis_update result = TETRAKIS_UPDATE;
        result.vertex_ranges = reinterpret_cast<const tetrakis_range*>(done.vertices.data());
        result.triangle_ranges = reinterpret_cast<const tetrakis_range*>(done.triangles.data());
        result.vertex_range_count = static_cast<std::uint32_t>(done.vertices.size());
        result.triangle_range_count = static_cast<std::uint32_t>(done.triangles.size());
        result.splits = done.splits;
        result.merges = done.merges;
        result.leaves = done.leaves;
        result.pixel_error = done.pixel_error;
        result.morph_scale = done.morph_scale;
        result.complete = done.complete ? 1 : 0;
        result.waiting = done.waiting;
        give(update, result, "update");
    });
}

const tetrakis_vertex* tetrakis_view_vertices(const tetrakis_view* view, uint32_t* count, uint32_t* capacity) {
    if (view == nullptr) return nullptr;
    const auto vertices = view->view.vertices();
    if (count != nullptr) *count = static_cast<std::uint32_t>(vertices.size());
    if (capacity != nullptr) *capacity = view->view.vertex_capacity();
    return reinterpret_cast<const tetrakis_vertex*>(vertices.data());
}
const uint32_t* tetrakis_view_triangles(const tetrakis_view* view, uint32_t* count, uint32_t* capacity) {
    if (view == nullptr) return nullptr;
    const auto triangles = view->view.triangles();
    if (count != nullptr) *count = static_cast<std::uint32_t>(triangles.size());
    if (capacity != nullptr) *capacity = view->view.triangle_capacity();
    return triangles.data()->data();
}
tetrakis_status tetrakis_take_snapshot(const tetrakis_view* view, tetrakis_snapshot** snapshot) {
    return guarded([&] {
        require(view, "view");
        require(snapshot, "snapshot");
        *snapshot = new tetrakis_snapshot(view->view.mesh());
    });
}
tetrakis_status tetrakis_write_snapshot(const tetrakis_snapshot* snapshot, const char* path) {
    return guarded([&] {
        require(snapshot, "snapshot");
        require(path, "path");
        write_mesh(path, snapshot->mesh);
    });
}
void tetrakis_free_snapshot(tetrakis_snapshot* snapshot) { delete snapshot; }
int tetrakis_snapshot_hit(const tetrakis_snapshot* snapshot, const double origin[3], const double direction[3],
                          double farthest, double* t, double normal[3]) {
    if (snapshot == nullptr || origin == nullptr || direction == nullptr) return 0;
    const RayHit hit = snapshot->bvh.intersect(vec(origin), vec(direction), 0, farthest);
    if (!hit.found()) return 0;
    if (t != nullptr) *t = hit.t;
    if (normal != nullptr) {
        const auto& corner = snapshot->mesh.triangles[hit.triangle];
        const auto at = [&](std::size_t k) { return snapshot->mesh.positions[corner[k]]; };
        give(unit_or_zero(glm::cross(at(1) - at(0), at(2) - at(0))), normal);
    }
    return 1;
}
tetrakis_status tetrakis_set_view_origin(tetrakis_view* view, const double origin[3]) {
    return guarded([&] {
        require(view, "view");
        require(origin, "origin");
        view->view.set_origin(vec(origin));
    });
}
