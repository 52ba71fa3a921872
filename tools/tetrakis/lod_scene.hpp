#pragma once

#include "../../eval/lod/view.hpp"
#include "../../eval/lod_surfaces/surface.hpp"
#include "../../eval/lod_terrain/tiled_terrain.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/obj/obj_reader.hpp"
#include "files.hpp"
#include "run_options.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// Position and target of the camera in one frame.
struct CameraPlace {
    Vec3d eye{}, target{};
    double fov_degrees = 60;
    Vec3d about_up{0, 0, 1};

    Vec3d forward() const { return glm::normalize(target - eye); }
    /// about_up, or another direction if the camera looks along about_up.
    Vec3d up() const {
        return std::abs(glm::dot(forward(), about_up)) < 0.999 ? about_up : Vec3d(about_up.y, about_up.z, about_up.x);
    }
    lod::Camera lod_camera(int width, int height) const;
};

/// The surface that `tetrakis lod` flies over.
struct LodScene {
    std::unique_ptr<const lod::Surface> surface;
    const lod::TiledTerrain* tiles = nullptr;  ///< the surface, if it is a tiled terrain
    std::string description;                   ///< such as "512 x 512 samples"
    std::function<double(const Vec3d&)> low;   ///< height of the ground below a point; empty for control meshes
    Vec3d middle{};
    double size = 1;        ///< shorter side of a terrain, else the diameter
    Vec3d up{0, 0, 1};      ///< y for control meshes
    bool is_round = false;  ///< "up" is outwards, as on a planet
    std::uint64_t surface_bytes = 0;

    Vec3d up_at(const Vec3d& place) const { return is_round ? glm::normalize(place - middle) : up; }
    /// Height of a point above the ground below it. Not of control meshes.
    double height_at(const Vec3d& place) const {
        return glm::dot(up_at(place), place - (is_round ? middle : Vec3d(0))) - low(place);
    }
    /// Whether the origin of a view's vertices has to move to the eye: their rounding to floats would otherwise be more
    /// than 6e-5 of the distance to the ground, a tenth of a pixel. Control meshes may be a thousandth of their size
    /// away.
    bool is_far(const Vec3d& origin, const Vec3d& eye) const {
        return glm::length(eye - origin) > 1000 * (low ? std::abs(height_at(eye)) : 1e-3 * size);
    }
};

/// Options of the command line that choose a scene: a terrain, tiles, a planet, a control mesh, or a fractal.
struct LodInput {
    HeightInput heights;                       ///< no path: a fractal
    std::vector<std::filesystem::path> faces;  ///< faces 2 to 6 of the cube, for a planet from six files
    std::optional<std::uint64_t> fractal;      ///< seed of the fractal
    double planet_radius = 0;                  ///< 0: no planet
    std::string scheme;
    int level = 0;  ///< 0: the surface's default
    std::uint64_t cache_bytes = lod::TiledTerrainOptions().cache_bytes;
    ReadOptions read_mesh;

    void add(CommandLine command);
    std::filesystem::path title() const;  ///< for messages: the (first) file, or for example "fractal 7"
    /// All input files, and the camera path `path`.
    std::vector<std::filesystem::path> inputs(const std::filesystem::path& path) const;
    /// @param warnings  receives a warning if heights were filled or faces were cut
    /// @throws InputError, UsageError, Error (memory_limit, cancelled)
    LodScene load(const Run& process, std::vector<std::string>& warnings) const;
};

/// Reads a camera path: a JSON list of {"eye": [x, y, z], "target": [x, y, z], "fov_degrees": a}. Frames are at equal
/// steps along the list, linearly between its entries.
/// @throws InputError
std::vector<CameraPlace> cameras_of(const std::filesystem::path& path, std::uint32_t frames);

/// Cameras on a circle around the middle of a scene. They look at it from outside, or (`fly`) ahead above the ground.
std::vector<CameraPlace> circle(const LodScene& scene, std::uint32_t frames, bool fly);

}  // namespace tetrakis::cli
